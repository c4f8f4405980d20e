"""The training loop: steps, a learning-rate schedule, and averaged weights."""

import copy
import functools
import pathlib
import time
from typing import NamedTuple

import torch
from torch import Tensor, nn

from adopt import adopt
from dataset import Batch, Batches
from losses import Losses, losses
from network import Network, Prediction

SEED = 20
PEAK_RATE = 3e-3
# Factor to the rates when continuing from a trained network.
CONTINUED_RATE = 0.5
WARM_UP = 0.03
WEIGHT_DECAY = 0.02
MAX_GRADIENT = 10.0
AVERAGE_OVER_STEPS = 400
REPORT_EVERY, SAVE_EVERY = 50, 200
STATISTICS_BATCHES = 24
# Channels of a pixel side by side: convolutions on a CPU take half the time.
LAYOUT = torch.channels_last


class State(NamedTuple):
    """State to continue a training from."""

    network: Network
    average: Network
    optimizer: torch.optim.Optimizer


def new_state() -> State:
    torch.manual_seed(SEED)
    network = Network().to(memory_format=LAYOUT)
    decayed = [weight for weight in network.parameters() if weight.dim() > 1]
    others = [weight for weight in network.parameters() if weight.dim() <= 1]
    optimizer = torch.optim.AdamW([{"params": decayed, "weight_decay": WEIGHT_DECAY},
                                   {"params": others, "weight_decay": 0.0}], lr=PEAK_RATE)
    return State(network, copy.deepcopy(network).eval().requires_grad_(False), optimizer)


def learning_rate(progress: float) -> float:
    """Rises during the warm-up, then falls as a cosine; progress 0..1."""
    if progress < WARM_UP:
        return PEAK_RATE * (0.02 + progress / WARM_UP)
    falling = (min(progress, 1.0) - WARM_UP) / (1 - WARM_UP)
    return PEAK_RATE * (0.01 + 0.99 * 0.5 * (1 + float(torch.cos(torch.tensor(torch.pi * falling)))))


def update_average(average: nn.Module, network: nn.Module, step: int) -> None:
    """Moves the averaged weights towards the present ones; faster at first, when these change fast."""
    part = max(1 / AVERAGE_OVER_STEPS, 1 / (step / 4 + 1))
    for mean, now in zip(average.state_dict().values(), network.state_dict().values()):
        if mean.dtype.is_floating_point:
            mean.lerp_(now, part)
        else:
            mean.copy_(now)


def save(path: pathlib.Path, state: State, step: int) -> None:
    """Replaces the checkpoint atomically: after an interruption the former one remains."""
    partial = path.with_suffix(".partial")
    torch.save({"network": state.network.state_dict(), "average": state.average.state_dict(),
                "optimizer": state.optimizer.state_dict(), "step": step}, partial)
    partial.replace(path)


def restore(path: pathlib.Path, state: State) -> int:
    """Loads a checkpoint if there is one; returns the steps taken so far."""
    if not path.exists():
        return 0
    saved = torch.load(path)
    state.network.load_state_dict(saved["network"])
    state.average.load_state_dict(saved["average"])
    state.optimizer.load_state_dict(saved["optimizer"])
    return saved["step"]


def restored_average(path: pathlib.Path) -> Network:
    """The averaged network of a checkpoint. Raises FileNotFoundError if there is none."""
    state = new_state()
    if restore(path, state) == 0:
        raise FileNotFoundError(f"there is no {path}; train first")
    return state.average


@functools.cache
def computes_bfloat16() -> bool:
    """Whether the processor has bfloat16 instructions: convolutions then take less than half the time."""
    information = pathlib.Path("/proc/cpuinfo")
    return information.exists() and "avx512_bf16" in information.read_text()


def train_step(state: State, batch: Batch, rate: float) -> Losses:
    """One optimisation step; returns the losses before it."""
    for group in state.optimizer.param_groups:
        group["lr"] = rate
    with torch.autocast("cpu", torch.bfloat16, enabled=computes_bfloat16()):
        prediction = state.network(batch.pictures.to(memory_format=LAYOUT))
    found = losses(Prediction(*(part.float() for part in prediction)), batch)
    state.optimizer.zero_grad()
    found.total().backward()
    nn.utils.clip_grad_norm_(state.network.parameters(), MAX_GRADIENT)
    state.optimizer.step()
    return found


def mean_of(before: Network, after: Network, pictures: list[Tensor]) -> Network:
    """The network with the mean of both weights; normalisations get the statistics of `pictures` [B, 2, H, W].

    It gains most of what a continued training learns, and loses little of what its scenes do not show (Wortsman et al., "Robust
    fine-tuning of zero-shot models", 2022).
    """
    mean = copy.deepcopy(before)
    for weight, other in zip(mean.state_dict().values(), after.state_dict().values()):
        if weight.dtype.is_floating_point:
            weight.lerp_(other, 0.5)
    for module in mean.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.reset_running_stats()
            module.momentum = None
    mean.train()
    with torch.no_grad():
        for batch in pictures:
            mean(batch)
    return mean.eval()


def train(recordings: list[pathlib.Path], steps: int, checkpoint: pathlib.Path, model: pathlib.Path | None = None) -> Network:
    """Trains on simulated recordings until step `steps`, counting those before `checkpoint`; returns the averaged network.

    With an ONNX file `model` it begins with its weights, unless there is a checkpoint, and returns the mean of them and those after
    the training.
    """
    state = new_state()
    first = restore(checkpoint, state)
    for_statistics = range(STATISTICS_BATCHES if model else 0)
    batches = iter(torch.utils.data.DataLoader(Batches(recordings, SEED), batch_size=None, num_workers=1,
                                               sampler=[*for_statistics, *range(first, steps)]))
    pictures = [next(batches).pictures for _ in for_statistics]
    before = None
    if model:
        before = Network()
        adopt(before, model, pictures)
        if first == 0:
            state.network.load_state_dict(before.state_dict())
    highest = CONTINUED_RATE if model else 1.0
    state.network.train()
    begin = time.monotonic()
    for step, batch in enumerate(batches, first):
        if step % SAVE_EVERY == 0 and step > first:
            save(checkpoint, state, step)
        found = train_step(state, batch, highest * learning_rate(step / steps))
        update_average(state.average, state.network, step)
        if step % REPORT_EVERY == 0:
            print(f"step {step} after {(time.monotonic() - begin) / 60:.1f} min: score {found.score:.3f}, box {found.box:.3f}, "
                  f"mask {found.mask:.3f}", flush=True)
    save(checkpoint, state, steps)
    return mean_of(before, state.average, pictures) if before else state.average
