"""Writes the network as ONNX readable by OpenCV's DNN."""

import copy
import pathlib

import cv2
import numpy as np
import onnx
import torch
from torch import Tensor, nn

from network import CHANNELS, OUTPUTS, Network

OPSET = 12
# Between OpenCV and PyTorch, for pixels, scores and coefficients: absolute up to 1, relative above.
MAX_DIFFERENCE = 1e-3
# Rows and columns.
TRIED_SIZES = ((256, 832), (192, 640), (416, 576))


class Exported(nn.Module):
    """The network with one output map for each stride: channels left, top, right, bottom (pixels from the middle of the cell), class
    scores, mask coefficients; and the prototypes."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, picture: Tensor) -> tuple[Tensor, ...]:
        maps, prototypes = self.network.maps(picture)
        return (*(torch.cat((distances, torch.sigmoid(scores), coefficients), 1) for scores, distances, coefficients in maps),
                prototypes)


def export(network: Network, path: pathlib.Path) -> None:
    """Writes `network` for pictures of any size in multiples of 32, normalisation folded into the convolutions, and checks it in OpenCV.

    Raises RuntimeError if OpenCV computes a different result.
    """
    exported = Exported(copy.deepcopy(network)).eval()
    any_size = {2: "height", 3: "width"}
    torch.onnx.export(exported, torch.zeros(1, CHANNELS, *TRIED_SIZES[0]), str(path), opset_version=OPSET, input_names=["picture"],
                      output_names=list(OUTPUTS), dynamic_axes={"picture": any_size}, do_constant_folding=True)
    model = onnx.load(str(path))
    _spell_out_shared_weights(model.graph)
    onnx.checker.check_model(model)
    onnx.save(model, str(path))
    _try_in_opencv(exported, path)


def _spell_out_shared_weights(graph: onnx.GraphProto) -> None:
    """Duplicates shared weights: the exporter writes Identity nodes of weights, which OpenCV 4.6 cannot read."""
    weights = {weight.name: weight for weight in graph.initializer}
    for node in [node for node in graph.node if node.op_type == "Identity" and node.input[0] in weights]:
        copied = graph.initializer.add()
        copied.CopyFrom(weights[node.input[0]])
        copied.name = node.output[0]
        graph.node.remove(node)


def _try_in_opencv(exported: Exported, path: pathlib.Path) -> None:
    """Compares all outputs on a few pictures of blurred noise, one size after the other."""
    model = cv2.dnn.readNetFromONNX(str(path))
    random = np.random.default_rng(1)
    for (height, width), blur in zip(TRIED_SIZES, (1.0, 4.0, 16.0)):
        picture = cv2.GaussianBlur(random.random((height, width, CHANNELS), np.float32), (0, 0), blur)
        picture = cv2.normalize(picture, None, 0, 1, cv2.NORM_MINMAX).transpose(2, 0, 1)[None].copy()
        model.setInput(picture)
        computed = model.forward(OUTPUTS)
        with torch.no_grad():
            expected = exported(torch.from_numpy(picture))
        for name, ours, theirs in zip(OUTPUTS, expected, computed):
            difference = float((np.abs(ours.numpy() - theirs) / np.maximum(1, np.abs(theirs))).max())
            if not difference < MAX_DIFFERENCE:
                raise RuntimeError(f"OpenCV computes {path} wrongly: {name} differs by {difference} at {width}x{height}")
