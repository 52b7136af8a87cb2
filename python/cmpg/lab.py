"""Measurements: methods of sampling side by side, and options that trade speed for accuracy. The commands `compare` and `tradeoff`, with their numbers.

    found = cmpg.lab.compare("scenes/box/scene.gltf", "painting.baseColor", mode="forward", width=64, methods=["plain", "conditional"])
    for row in found["table"]:
        print(row["method"], row["relative_variance"], row["ratio"])
"""

from __future__ import annotations

import csv
import json
import os
import pathlib
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import Image, Names, Path, load_image, names_of
from ._errors import Error, UsageError
from ._scene import Scene

try:
    from . import _lab
except ImportError as error:
    if "libcairo" in str(error):
        raise ImportError("cmpg.lab draws with Cairo: install the package libcairo2") from error
    raise

__all__ = ["compare", "tradeoff"]

Picture = "npt.ArrayLike | Path"
Progress = Callable[[str], None]


class _Run:
    """Options as a run.json has them, with the files that they name."""

    def __init__(self, command: str, scene: Scene | Path, param: Names, folder: pathlib.Path, options: Mapping[str, Any]) -> None:
        self.folder = folder
        self.files = 0
        source = scene.source if isinstance(scene, Scene) else os.fspath(scene)
        self.config: dict[str, Any] = {"command": command, "input": source, "param": names_of(param)}
        given = {name.replace("_", "-"): _plain(name, value) for name, value in options.items() if value is not None}
        if isinstance(scene, Scene):
            own = self.of(scene)
            if "environment" in given:
                own.pop("environment-rotation", None)  # of the picture that is replaced
            for name in ("define", "texture", "set"):  # those of `options` hold where both name the same
                if name in own:
                    given[name] = own[name] + names_of(given.get(name, []))
            given = own | given
        self.config |= given

    def of(self, scene: Scene) -> dict[str, Any]:
        """What makes a scene of its file."""
        own = dict(scene._given)
        changed = {name: scene[name].values for name in sorted(scene._changed)}
        if scene._resized:
            own["texture"] = [f"{name}={changed[name].shape[1]}x{changed[name].shape[0]}" for name in sorted(scene._resized)]
        if changed:
            own["set"] = [f"{name}={self.file(values)}" for name, values in changed.items()]
        return own

    def file(self, image: Any) -> str:
        """An image as a file: written, if it is none yet."""
        if isinstance(image, (str, os.PathLike)):
            return os.fspath(image)
        self.files += 1
        name = self.folder / f"given{self.files}.exr"
        np.asarray(image, dtype=np.float32).view(Image).save(name)
        return str(name)

    def give(self, target: Any, adjoint: Any, direction: Any) -> None:
        if target is not None:
            views = target if isinstance(target, Mapping) else {"": target}
            self.config["target"] = [(f"{camera}=" if camera else "") + self.file(image) for camera, image in views.items()]
        if adjoint is not None:
            self.config["adjoint"] = self.file(adjoint)
        if direction is not None:
            self.config["direction"] = self.file(direction)  # "one" and "self" stay what they are

    def measure(self, output: Path | None, progress: Progress | None) -> dict[str, Any]:
        folder = pathlib.Path(output) if output is not None else self.folder / "report"
        try:
            report = json.loads(_lab.measure(json.dumps(self.config), str(folder), progress))
        except Error as error:
            raise type(error)(_named(error.what), _named(error.cause), _named(error.remedy), error.options) from None
        result = {"table": report["table"], "columns": _columns(report["table"]), "device": report["device"], "seconds": report["seconds"]}
        result["files"] = dict(report["outputs"]) if output is not None else {}
        result["_outputs"] = report["outputs"]
        return result


def _plain(name: str, value: Any) -> Any:
    """The value of an option as JSON has it."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if name == "set" and isinstance(value, (str, Mapping)):  # as the other listings are lists, and as a Scene takes its values
        return [value] if isinstance(value, str) else [f"{parameter}={_plain(name, each)}" for parameter, each in value.items()]
    if isinstance(value, (list, tuple)):
        return [_plain(name, each) for each in value]
    if not isinstance(value, (str, int, float)):
        raise UsageError(f"{name} is a {type(value).__name__}", "", "give a number, a text or a file", [name])
    return value


def _named(text: str) -> str:
    """A message of the command line with options as they are called here."""
    return re.sub(r"(?<![^\s(])--([a-z]+(?:-[a-z]+)*)", lambda option: option[1].replace("-", "_"), text)


def _columns(table: list[dict[str, Any]]) -> dict[str, npt.NDArray[Any]]:
    """Columns of a table as arrays: NaN where a row has no number."""
    columns = {}
    for key in {key: None for row in table for key in row}:
        cells = [row.get(key) for row in table]
        if any(isinstance(cell, (str, bool)) for cell in cells):
            columns[key] = np.array([cell if cell is not None else "" for cell in cells])
        elif all(cell is None or isinstance(cell, (int, float)) for cell in cells):
            columns[key] = np.array([np.nan if cell is None else cell for cell in cells], dtype=np.float64)
    return columns


def _curves(file: str) -> dict[str, dict[str, dict[str, npt.NDArray[np.float64]]]]:
    curves: dict[str, dict[str, dict[str, list[float]]]] = {}
    with open(file, newline="") as rows:
        for row in csv.DictReader(rows):
            curve = curves.setdefault(row["mode"], {}).setdefault(row["method"], {"seconds": [], "passes": [], "mse": []})
            for key, values in curve.items():
                values.append(float(row[key] or "nan"))
    return {mode: {name: {key: np.array(values) for key, values in curve.items()} for name, curve in methods.items()} for mode, methods in curves.items()}


def _images(outputs: Mapping[str, str]) -> dict[str, Image]:
    return {name: load_image(file) for name, file in outputs.items() if file.endswith(".exr")}


def compare(scene: Scene | Path, param: Names, *, methods: str | Sequence[str] = "plain,primal,conditional,ours", mode: str | Sequence[str] = "reverse",
            target: Any = None, adjoint: Any = None, direction: Any = None, spp_gradient: int | None = None, seeds: int | None = None,
            time: float | None = None, reference: Path = "auto", reference_time: float | None = None, train: int | None = None, width: int | None = None,
            height: int | None = None, output: Path | None = None, progress: Progress | None = None, **options: Any) -> dict[str, Any]:
    """Methods of sampling side by side, at equal samples or in equal time: their variance, bias and efficiency.

    Args:
        scene: a file, or a Scene: as it was made, with the sizes and values that were set.
        param: names or globs of what is differentiated or recovered.
        methods: names as of the command line: "plain", "primal", "differential", "uniform", "conditional", "ours", each with parts, as in
            "conditional+pixels+roulette".
        mode: "forward" (the derivative image), "reverse" (the gradient of an adjoint or of a target's loss), "optimize" (whole recoveries), or several.
        target: an image (height, width, 3) or a file; several by the camera's name, for "optimize".
        adjoint: (height, width, 3) or a file, for "reverse".
        direction: of "forward": "one", "self", or an image of the parameter's shape.
        spp_gradient: samples per pixel of a pass; None: as spp (16), of "optimize" 4.
        seeds: passes of each method, or the fewest under `time`; None: 16 and 4.
        time: seconds of passes of each method; None: equal samples.
        reference: "auto", or what is right: a file, or a folder of several.
        reference_time: most seconds for an automatic reference; None: twice those of all passes.
        train: learning passes before; None: 8.
        width, height: in pixels.
        output: a folder for the report, tables, plots and images; None: none is kept.
        progress: called now and then with what is being done.
        options: others of the command line, with _ for -: max_depth, loss, steps, memory ...

    Returns:
        "table": a dict per method and one of the reference, as --json prints it: "method", "passes", "seconds", "relative_variance" (of one pass, over
            the squared length of the truth), "bias" (relative, with "bias_95", half its 95 % interval), "efficiency" (1 / (variance x seconds)),
            "ratio" (of efficiencies, to the first method), each with its standard error ("..._error").
        "columns": the same as arrays, one entry per row.
        "curves": mode -> method -> {"seconds", "passes", "mse"}: arrays of one length.
        "images": mode -> {"reference", each method}: the mean derivative image, or gradients in the parameter's shape; of several parameters
            "method.parameter". One channel is there three times.
        "device", "seconds" (of the parts of the run), "files" (where `output` is given).

    Raises:
        UsageError: options that make no sense, or unknown names.
        InputError: a file that cannot be read or does not fit.
    """
    modes = [mode] if isinstance(mode, str) else list(mode)
    with tempfile.TemporaryDirectory() as folder:
        run = _Run("compare", scene, param, pathlib.Path(folder), {
            **options, "methods": methods if isinstance(methods, str) else ",".join(methods), "mode": ",".join(modes), "spp_gradient": spp_gradient,
            "seeds": seeds, "time": time, "reference": os.fspath(reference), "reference_time": reference_time, "train": train, "width": width,
            "height": height})
        run.give(target, adjoint, direction)
        result = run.measure(output, progress)
        outputs = result.pop("_outputs")
        result["curves"] = _curves(outputs["error_over_time"])
        names = ",".join(modes).split(",")
        if len(names) == 1:
            result["images"] = {names[0]: _images(outputs)}
        else:
            of = {name: {key[len(name) + 1:]: file for key, file in outputs.items() if key.startswith(name + ".")} for name in names}
            result["images"] = {name: _images(files) for name, files in of.items()}
    return result


def tradeoff(scene: Scene | Path, param: Names, *, time: float | None = None, seeds: int | None = None, target: Any = None, adjoint: Any = None,
             direction: Any = None, width: int | None = None, height: int | None = None, output: Path | None = None, progress: Progress | None = None,
             **options: Any) -> dict[str, Any]:
    """Which options trade speed for accuracy on a scene, which of them are on the frontier, and how much they gain.

    Args:
        scene, param, target, adjoint, direction, width, height, output, progress, options: as in compare(). A target measures steps of a recovery, an
            adjoint gradients, neither derivative images.
        time: seconds of the whole measurement, about; None: 1800.
        seeds: trainings of each setting; None: 3.

    Returns:
        "table": a dict per setting, as --json prints it: "part" ("single" or "combined"), "setting", "seconds_per_pass", "relative_variance",
            "error_of_pass", "gain" (of efficiency, over the defaults), "frontier" ...
        "columns": the same as arrays, one entry per row.
        "images": {"reference": ...}, as in compare().
        "device", "seconds", "files".

    Raises:
        UsageError, InputError: as compare().
    """
    if isinstance(target, Mapping) and len(target) > 1:
        raise UsageError("a trade-off takes one target", "", "measure one camera at a time", ["target"])
    with tempfile.TemporaryDirectory() as folder:
        run = _Run("tradeoff", scene, param, pathlib.Path(folder), {**options, "time": time, "seeds": seeds, "width": width, "height": height})
        run.give(target, adjoint, direction)
        result = run.measure(output, progress)
        result["images"] = _images(result.pop("_outputs"))
    return result
