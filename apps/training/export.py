"""Writes the network as ONNX in the signature of exported YOLOv8-seg models, as OpenCV's DNN can read it."""

import copy
import pathlib

import cv2
import numpy as np
import onnx
import torch
from torch import Tensor, nn

from network import Network, cell_middles

OPSET = 12
# Between what OpenCV computes and what the network is: pixels, scores and coefficients.
MAX_DIFFERENCE = 1e-3


class Exported(nn.Module):
    """The network with its answer decoded: rows cx, cy, w, h, class scores, mask coefficients; and the prototypes."""

    def __init__(self, network: Network, height: int, width: int) -> None:
        super().__init__()
        self.network = network
        middles, _ = cell_middles(height, width)
        self.register_buffer("middles", middles.T[None].contiguous())

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor]:
        prediction = self.network(picture)
        distances = prediction.distances.transpose(1, 2)
        before, after = distances[:, :2], distances[:, 2:]
        middle = self.middles + (after - before) * 0.5
        scores = torch.sigmoid(prediction.scores.transpose(1, 2))
        rows = torch.cat((middle, after + before, scores, prediction.coefficients.transpose(1, 2)), 1)
        return rows, prediction.prototypes


def export(network: Network, path: pathlib.Path, height: int, width: int) -> None:
    """Writes `network` for pictures of this size, normalisation folded into the convolutions, and tries it in OpenCV.

    Raises ValueError for a size that the network cannot have, RuntimeError where OpenCV computes something else.
    """
    if height % 32 or width % 32:
        raise ValueError(f"{width}x{height} is no size for the network; take multiples of 32")
    exported = Exported(copy.deepcopy(network), height, width).eval()
    torch.onnx.export(exported, torch.zeros(1, 1, height, width), str(path), opset_version=OPSET, input_names=["images"],
                      output_names=["output0", "output1"], do_constant_folding=True)
    model = onnx.load(str(path))
    _spell_out_shared_weights(model.graph)
    onnx.checker.check_model(model)
    onnx.save(model, str(path))
    _try_in_opencv(exported, path, height, width)


def _spell_out_shared_weights(graph: onnx.GraphProto) -> None:
    """Gives equal weights one copy each: the exporter writes Identity nodes of weights, which OpenCV 4.6 cannot read."""
    weights = {weight.name: weight for weight in graph.initializer}
    for node in [node for node in graph.node if node.op_type == "Identity" and node.input[0] in weights]:
        copied = graph.initializer.add()
        copied.CopyFrom(weights[node.input[0]])
        copied.name = node.output[0]
        graph.node.remove(node)


def _try_in_opencv(exported: Exported, path: pathlib.Path, height: int, width: int) -> None:
    """Compares both outputs on a few pictures of blurred noise."""
    model = cv2.dnn.readNetFromONNX(str(path))
    random = np.random.default_rng(1)
    for blur in (1.0, 4.0, 16.0):
        picture = cv2.GaussianBlur(random.random((height, width), np.float32), (0, 0), blur)
        picture = cv2.normalize(picture, None, 0, 1, cv2.NORM_MINMAX)[None, None]
        model.setInput(picture)
        computed = model.forward(["output0", "output1"])
        with torch.no_grad():
            expected = exported(torch.from_numpy(picture))
        for name, ours, theirs in zip(("output0", "output1"), expected, computed):
            difference = float(np.abs(ours.numpy() - theirs).max())
            if not difference < MAX_DIFFERENCE:
                raise RuntimeError(f"OpenCV computes {path} wrongly: {name} differs by {difference}")
