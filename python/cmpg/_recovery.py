"""Recoveries of parameters from images."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _cmpg
from ._arrays import Image, Names, Path, as_image, floats, load_image, names_of
from ._cmpg import PassReport, RecoveryStep
from ._errors import UsageError
from ._renderer import path_options
from ._scene import Device, Scene

MOST_TARGET_BYTES = _cmpg.Target.most_bytes


class Recovery(Iterator[RecoveryStep]):
    """Recovers parameters of a scene from images of it: an iterator over its steps.

    It takes a copy of the scene: its values are where the recovery begins, and stay as they are until apply().

    Args:
        scene: where it begins.
        target: what a camera saw: an array (height, width, 3) or a file; or several, by the camera's name. Alpha of a file weights its pixels;
            clipped pixels of 8-bit files and values that are not finite have no weight. Files beyond 256 MiB in all are read when a step sees them.
        param: names or globs of what is recovered.
        device: where; None: the scene's.
        steps: of the whole recovery and its schedule.
        spp: samples per pixel of the image of the first step.
        spp_gradient: of the derivative pass of a step.
        spp_difference: at most, that bring the image of the step before up to date: all where what is left of a squared loss is the image's noise, half
            where it is not and steps are long, 2 where neither; 0: every step renders its own of `spp`.
        loss: "mse", "l1", "smape" or "relative-mse".
        optimizer: "auto", "gauss-newton", "adam" or "sgd".
        rate: a number for all slots, or a number by the name of the slot, such as {"roughness": 0.01}.
        schedule: of the rate: "constant", "cosine" or "exponential".
        final_rate: what the schedule has multiplied the rate by at the last step.
        prior: what is known of textures: differences of neighbouring texels, root mean square d over the n channels, are as likely
            as exp(-prior n d); 0: nothing.
        total_variation: weight of the total variation of textures.
        views_per_step: of several targets; 0: all, of four and more at first one where Gauss-Newton recovers textures and no constants.
        warm_up: first steps, which only learn the guide.
        freeze: step from which on the guide stays as it is; 0: none.
        error_target: the gradient of each step is sampled until |standard error| / |gradient| is this small; `spp_gradient`, at least 8, is the most.
        mask: weights in [0, 1] of the targets' pixels, (height, width), or for targets that are files the file of an image.
        target_exposure: targets are multiplied by 2^target_exposure.
        The others as in Renderer.

    Raises:
        UsageError: options that make no sense, or unknown names.
        InputError: a target that cannot be read or does not fit.
    """

    def __init__(self, scene: Scene, target: npt.ArrayLike | Path | Mapping[str, npt.ArrayLike | Path], param: Names, *, device: Device | None = None,
                 steps: int = 200, spp: int = 16, spp_gradient: int = 4, spp_difference: int = 12, seed: int = 0, loss: str = "mse",
                 optimizer: str = "auto", rate: float | Mapping[str, float] | None = None, schedule: str = "constant", final_rate: float = 0.1,
                 prior: float = 8, total_variation: float = 0, views_per_step: int = 0, warm_up: int = 0, freeze: int = 0,
                 error_target: float = 0, mask: npt.ArrayLike | Path | None = None, target_exposure: float = 0, max_depth: int = 0, sampling: str = "auto",
                 pixel_sampling: str = "adjoint", roulette: str = "adjoint", positivize: bool = False, no_nee: bool = False, memory: int = 1024,
                 guide_memory: int = 64, sampler: str = "sobol", load_guide: Path | None = None,
                 keep_guide: bool = False, expert: Mapping[str, float] | None = None) -> None:
        paths = path_options(max_depth, sampling, pixel_sampling, roulette, positivize, no_nee, memory, guide_memory, sampler, load_guide, keep_guide, expert)
        views = target if isinstance(target, Mapping) else {"": target}
        targets: list[Any] = []
        for camera, image in views.items():
            held = sum(known.nbytes for known in targets)
            targets.append(target_of(image, camera, mask, target_exposure, held >= MOST_TARGET_BYTES))
        rates = [] if rate is None else list(rate.items()) if isinstance(rate, Mapping) else [("", float(rate))]
        self._handle = _cmpg.Recovery(
            (device or scene.device)._handle, scene._handle, targets, names_of(param), paths, steps=steps, spp=spp, spp_gradient=spp_gradient,
            spp_difference=spp_difference, seed=seed, loss=loss, optimizer=optimizer, rates=rates, schedule=schedule, final_rate=final_rate,
            prior=prior, total_variation=total_variation, views_per_step=views_per_step, warm_up=warm_up, freeze=freeze, error_target=error_target)
        self._infos = {info.name: info for info in self._handle.parameters()}

    def __iter__(self) -> Recovery:
        return self

    def __next__(self) -> RecoveryStep:
        if self.done:
            raise StopIteration
        return self.step()

    def step(self) -> RecoveryStep:
        """One step, also beyond `steps`. One that Ctrl-C ends has changed nothing and can be done again.

        Raises:
            NumericalError: no entry of the gradient is finite.
            DeviceError: the device is lost.
        """
        return self._handle.step()

    @property
    def steps_done(self) -> int:
        """Steps done so far, those before resume() included."""
        return self._handle.steps()

    @property
    def done(self) -> bool:
        """Whether all steps are done."""
        return self._handle.done()

    @property
    def parameters(self) -> list[str]:
        """Names of what is recovered, globs expanded."""
        return list(self._infos)

    def _info(self, name: str) -> _cmpg.ParameterInfo:
        if name not in self._infos:
            raise UsageError(f"{name} is not recovered", f"recovered are {', '.join(self._infos)}", "name it", ["param"])
        return self._infos[name]

    def __getitem__(self, name: str) -> Image:
        """The current values of a parameter, in its shape: a copy."""
        return as_image(self._handle.values(self._info(name)))

    def gradient(self, name: str) -> Image:
        """Of the last step, regulariser included, in the parameter's shape; zeros before the first."""
        return as_image(self._handle.gradient(self._info(name)))

    @property
    def history(self) -> list[RecoveryStep]:
        """What the steps done have found, those before resume() included: without warnings."""
        return self._handle.history()

    @property
    def report(self) -> PassReport:
        """What all passes so far cost and left out, and how directions are drawn now."""
        return self._handle.report()

    def image(self, target: int = 0, spp: int = 64, initial: bool = False) -> Image:
        """What the camera of a target (by its number) sees at the current values, or at those where the recovery began, (height, width, 3)."""
        return as_image(self._handle.image(target, spp, initial))

    @property
    def errors(self) -> dict[str, Any]:
        """Under an error target: how many "gradients" there were, how many of them "missed" it, and the "worst" error of these."""
        return self._handle.errors()

    def save_guide(self, file: Path) -> None:
        """Writes what was learned, for `load_guide`.

        Raises:
            UsageError: nothing is learned.
            OutputError: it cannot be written.
        """
        self._handle.save_guide(file)

    def apply(self, scene: Scene) -> None:
        """Puts the current values into a scene: that it was made of, or a copy of it."""
        self._handle.apply(scene._handle)
        scene._revision += 1
        scene._changed.update(self._infos)

    def save(self, folder: Path) -> None:
        """Writes all that resume() needs, and keeps the one before.

        Raises:
            OutputError: that fails.
        """
        self._handle.save(folder)

    def resume(self, folder: Path) -> bool:
        """Continues from what save() wrote to what the saved recovery would have found, bit for bit on the same device.

        Returns:
            False where the folder has nothing of the kind.

        Raises:
            UsageError: it is of a recovery with other options; the first difference is named.
            InputError: it is of another scene or target, or cannot be read.
        """
        return self._handle.resume(folder)


def target_of(image: Any, camera: str, mask: Any, exposure: float, stream: bool = False) -> Any:
    if isinstance(image, (str, os.PathLike)):
        if mask is not None and not isinstance(mask, (str, os.PathLike)):
            raise UsageError("a target that is a file takes a mask that is a file", "", "load the target: cmpg.load_image(file)", ["mask"])
        load = _cmpg.Target.stream if stream else _cmpg.Target.load
        return load(image, camera, "" if mask is None else mask, exposure)
    if isinstance(mask, (str, os.PathLike)):
        mask = load_image(mask).mean(axis=2)
    return _cmpg.Target(floats(image) * np.float32(2.0**exposure), camera, None if mask is None else floats(mask))
