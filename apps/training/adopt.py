"""Loads the weights of an exported model into a network for further training."""

import pathlib

import numpy as np
import onnx
import torch
from onnx import numpy_helper
from torch import Tensor, nn

from network import CHANNELS, Network


def adopt(network: Network, model: pathlib.Path, pictures: list[Tensor]) -> None:
    """Sets `network` to the weights of an ONNX file written by export(); normalisations get the statistics of `pictures` [B, 2, H, W].

    In the file, every normalisation is folded into the convolution before it. Here it is separated again: its mean and
    variance are those of the convolution's output on the pictures, and its scale and offset cancel them, so that the
    network computes the same as the model. Raises ValueError if the file is of another network.
    """
    convolutions = _in_order_of_use(network)
    graph = onnx.load(str(model)).graph
    weights = {weight.name: numpy_helper.to_array(weight) for weight in graph.initializer}
    nodes = [node for node in graph.node if node.op_type == "Conv"]
    _add_channels(weights, nodes[0].input[1], convolutions[0].weight.shape[1])
    if [weights[node.input[1]].shape for node in nodes] != [tuple(convolution.weight.shape) for convolution in convolutions]:
        raise ValueError(f"{model} is not a model of this network; train without --from")
    normalisations = _normalisations(network)
    with torch.no_grad():
        for node, convolution in zip(nodes, convolutions):
            weight, bias = (torch.from_numpy(np.array(weights[name])) for name in node.input[1:3])
            convolution.weight.copy_(weight)
            if convolution in normalisations:
                _set(normalisations[convolution], torch.zeros_like(bias), torch.ones_like(bias), bias)
            else:
                convolution.bias.copy_(bias)
        for convolution, (mean, variance) in _output_statistics(network, list(normalisations), pictures).items():
            normalisation = normalisations[convolution]
            _set(normalisation, mean, variance, normalisation.bias + mean)


def _add_channels(weights: dict[str, np.ndarray], first: str, channels: int) -> None:
    """Gives the first convolution of a network without disparities zero weights for them."""
    missing = max(0, channels - weights[first].shape[1])
    weights[first] = np.pad(weights[first], ((0, 0), (0, missing), (0, 0), (0, 0)))


def _set(normalisation: nn.BatchNorm2d, mean: Tensor, variance: Tensor, bias: Tensor) -> None:
    """Sets the statistics, and a scale that cancels the division by them."""
    normalisation.running_mean.copy_(mean)
    normalisation.running_var.copy_(variance)
    normalisation.weight.copy_((variance + normalisation.eps).sqrt())
    normalisation.bias.copy_(bias)


def _in_order_of_use(network: Network) -> list[nn.Conv2d]:
    """The network's convolutions in the order of computation, which is their order in the file."""
    used = []
    handles = [module.register_forward_hook(lambda module, *_: used.append(module))
               for module in network.modules() if isinstance(module, nn.Conv2d)]
    was_training = network.training
    with torch.no_grad():
        network.eval()(torch.zeros(1, CHANNELS, 64, 64))
    network.train(was_training)
    for handle in handles:
        handle.remove()
    return used


def _normalisations(network: Network) -> dict[nn.Conv2d, nn.BatchNorm2d]:
    """The normalisation after each convolution that has one."""
    found = {}
    for sequence in network.modules():
        if isinstance(sequence, nn.Sequential):
            parts = list(sequence)
            found.update({before: after for before, after in zip(parts, parts[1:])
                          if isinstance(before, nn.Conv2d) and isinstance(after, nn.BatchNorm2d)})
    return found


def _output_statistics(network: Network, convolutions: list[nn.Conv2d],
                       pictures: list[Tensor]) -> dict[nn.Conv2d, tuple[Tensor, Tensor]]:
    """Mean and variance [channels] of each convolution's output on the pictures."""
    sums = {convolution: [0, 0.0, 0.0] for convolution in convolutions}

    def note(convolution: nn.Conv2d, _: tuple[Tensor], output: Tensor) -> None:
        total = sums[convolution]
        total[0] += output.numel() // output.shape[1]
        total[1] = total[1] + output.double().sum((0, 2, 3))
        total[2] = total[2] + output.double().square().sum((0, 2, 3))

    handles = [convolution.register_forward_hook(note) for convolution in convolutions]
    network.eval()
    for batch in pictures:
        network(batch)
    for handle in handles:
        handle.remove()
    return {convolution: ((total / count).float(), (squares / count - (total / count) ** 2).float())
            for convolution, (count, total, squares) in sums.items()}
