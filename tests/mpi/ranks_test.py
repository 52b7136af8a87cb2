#!/usr/bin/env python3
"""Runs on several ranks give the bytes of runs on one.

usage: ranks_test.py SCENARIO PROGRAM SOURCE MPIRUN

same      images, gradients and recoveries from 1 and 3 ranks, some with several bands of pixels a rank; a recovery from 1, 2, 3 and 4
all       all of these from 1, 2, 3 and 4 ranks, images of derivatives and recoveries by Adam as well
many      the same recovery from 16 ranks, more than there are processors
resume    a checkpoint of 2 ranks goes on with 3
killed    a rank that is killed ends the run, with a checkpoint that goes on (Open MPI alone: MPICH's launcher kills all others at once)
failed    a rank that fails alone is named, and all end
refused   what several ranks cannot do
"""
import csv
import hashlib
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

scenario, program, source, launcher = sys.argv[1:5]
mpich = "mpich" in launcher
box = f"{source}/scenes/box/scene.gltf"
environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "LP_NUM_THREADS": "1"}
scratch = tempfile.TemporaryDirectory(prefix="cmpg-ranks-")
folder = pathlib.Path(scratch.name)


def launch(ranks):
    return [launcher, "-n", str(ranks)] + ([] if mpich else ["--oversubscribe", "--bind-to", "none"])


def command(ranks, arguments):
    return (launch(ranks) if ranks > 1 else []) + [program, "--headless", *arguments]


def run(ranks, arguments):
    done = subprocess.run(command(ranks, arguments), env=environment, capture_output=True, text=True, timeout=500)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode} from {ranks} ranks: {arguments}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def digest(path):
    """Of a file, or of all that a run found: loss.csv without its times, and no log, run.json, pictures with times or checkpoints."""
    total = hashlib.sha256()
    path = pathlib.Path(path)
    files = [path] if path.is_file() else sorted(f for f in path.rglob("*") if f.suffix in (".exr", ".guide", ".csv"))
    if not files:
        sys.exit(f"nothing was written: {path}")
    for file in files:
        total.update(str(file.relative_to(path)).encode())
        if file.suffix == ".csv":
            for row in csv.DictReader(file.open()):
                total.update(repr([v for k, v in row.items() if not k.startswith("seconds")]).encode())
        else:
            total.update(file.read_bytes())
    return total.hexdigest()


def target():
    image = folder / "target.exr"
    if not image.exists():
        run(1, ["render", box, "--set", "painting.baseColor=0.3", "--width", "48", "--height", "40", "--spp", "4", "--quiet", "-o", str(image)])
    return str(image)


def optimize(name, steps, *more):
    return ["optimize", box, "--param", "painting.baseColor", "--param", "light.emission", "--target", f"front={target()}", "--spp", "4", "--spp-gradient", "4",
            "--steps", str(steps), "--save-guide", str(folder / name / "learned.guide"), "--quiet", "-o", str(folder / name), *more]


def compare(counts, outputs):
    """outputs: name -> arguments that write what is named"""
    for name, arguments in outputs.items():
        found = {}
        for ranks in counts:
            output = folder / (f"{ranks}-{name}" + (".exr" if not name.startswith("run") else ""))
            run(ranks, arguments(output))
            found[ranks] = digest(output)
            print(f"{name:20} {ranks:2} ranks  {found[ranks][:16]}", flush=True)
        if len(set(found.values())) != 1:
            sys.exit(f"{name} differs")


def recovery(output, *more):
    return optimize(output.name, 3, *more)


def same(counts=(1, 3)):
    size = ["--width", "48", "--height", "40", "--quiet"]
    compare((1, 2, 3, 4), {"run": recovery})
    compare(counts, {
        "image": lambda o: ["render", box, *size, "--spp", "256", "-o", str(o)],
        "guided-image": lambda o: ["render", box, *size, "--spp", "4", "--sampling", "conditional", "--train", "2", "-o", str(o)],
        "reverse": lambda o: ["gradient", box, "--param", "painting.baseColor", "--target", target(), "--spp", "4", "--spp-gradient", "128", "--train", "3", "--quiet",
                              "-o", str(o)],
        "run-views": lambda o: recovery(o, "--target", f"front={target()}"),
        "run-turns": lambda o: recovery(o, "--target", f"front={target()}", "--views-per-step", "1"),
    })
    if 4 in counts:  # their sums are those of images and of gradients above
        compare(counts, {
            "forward": lambda o: ["gradient", box, *size, "--param", "painting.baseColor", "--spp-gradient", "4", "-o", str(o)],
            "run-adam": lambda o: recovery(o, "--optimizer", "adam", "--spp-difference", "0", "--sampling", "conditional"),
        })


def timed():
    """A run in limited time, whose ranks agree on its end, is repeated by the options that it leaves. (Clocks that tell different numbers of samples are rare.)"""
    run(2, optimize("timed", 100000, "--time-budget", "2s"))
    again = folder / "again"
    run(1, ["--config", str(folder / "timed" / "run.json"), "--quiet", "--save-guide", str(again / "learned.guide"), "-o", str(again)])
    if digest(folder / "timed") != digest(again):
        sys.exit("the options that a run in limited time has left find something else")


def everything():
    same((1, 2, 3, 4))


def many():
    compare((1, 16), {"run": recovery})


def resume():
    run(1, optimize("whole", 6))
    run(2, optimize("parts", 6, "--stop-after", "3", "--checkpoint-every", "1"))
    run(3, optimize("parts", 6, "--stop-after", "6", "--resume", str(folder / "parts")))
    if digest(folder / "whole") != digest(folder / "parts"):
        sys.exit("a run that went on with more ranks found something else")


def children(pid):
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            found += [int(child)] + children(int(child))
    return found


def killed():
    run(1, optimize("whole", 40))
    name = "killed"
    process = subprocess.Popen(command(2, optimize(name, 40, "--checkpoint-every", "1000000")), env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True)
    losses = folder / name / "loss.csv"
    while process.poll() is None and (not losses.exists() or len(losses.read_text().splitlines()) < 4):
        time.sleep(0.05)
    for pid in children(process.pid):
        variables = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
        if b"OMPI_COMM_WORLD_RANK=1" in variables:
            os.kill(pid, signal.SIGKILL)
    text, _ = process.communicate(timeout=60)
    if process.returncode == 0 or "another rank ended" not in text:
        sys.exit(f"exit code {process.returncode}: {text}")
    if not list((folder / name).glob("*checkpoint*")):
        sys.exit(f"no checkpoint: {sorted(f.name for f in (folder / name).iterdir())}\n{text}")
    run(1, optimize(name, 40, "--resume", str(folder / name)))
    if digest(folder / "whole") != digest(folder / name):
        sys.exit("the run that lost a rank found something else")


def failed():
    arguments = [program, "--headless", *optimize("failed", 3)]
    both = [launcher] + ([] if mpich else ["--oversubscribe"])
    both += ["-n", "1", *arguments, ":", "-n", "1", "env", "VK_ICD_FILENAMES=/nowhere", "VK_DRIVER_FILES=/nowhere", *arguments]
    done = subprocess.run(both, env=environment, capture_output=True, text=True, timeout=120)
    if done.returncode == 0 or "rank 1 of 2 failed" not in done.stderr:
        sys.exit(f"exit code {done.returncode}: {done.stdout}{done.stderr}")


def refused():
    arguments = ["compare", box, "--param", "painting.baseColor", "-o", str(folder / "c")]
    done = subprocess.run(command(2, arguments), env=environment, capture_output=True, text=True, timeout=120)
    # One rank ends the other, by which MPICH's launcher ends with 9 where that is first.
    if done.returncode not in ((2, 9) if mpich else (2,)) or "does not run on several ranks" not in done.stdout + done.stderr:
        sys.exit(f"compare was not refused, exit code {done.returncode}: {done.stdout}{done.stderr}")
    alone = folder / "cmpg-vk"  # without its modules
    alone.write_bytes(pathlib.Path(program).read_bytes())
    alone.chmod(0o755)
    variables = {"PMI_SIZE": "2", "PMI_RANK": "0"} if mpich else {"OMPI_COMM_WORLD_SIZE": "2", "OMPI_COMM_WORLD_RANK": "0"}
    done = subprocess.run([str(alone), "--version"], env={**environment, **variables}, capture_output=True, text=True, timeout=60)
    if done.returncode != 4 or "has no module for its MPI" not in done.stderr:
        sys.exit(f"exit code {done.returncode}: {done.stdout}{done.stderr}")


if scenario == "killed" and mpich:
    print("MPICH's launcher kills all ranks at once, so none is left to keep a checkpoint")
    sys.exit(77)
{"same": same, "timed": timed, "all": everything, "many": many, "resume": resume, "killed": killed, "failed": failed, "refused": refused}[scenario]()
