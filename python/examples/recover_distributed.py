"""Recovers the painting of the box scene in several processes with torch.distributed: each draws random numbers of its own, gradients are averaged.

    torchrun --nproc-per-node 2 python/examples/recover_distributed.py [STEPS [FOLDER]]

All processes hold the same texture. In a step each renders the room with its own seed, and the mean of their gradients moves it: what twice the samples of one process
would give. Views could be dealt out as well. Writes the texture to FOLDER (out/distributed).
"""

import os
import pathlib
import sys

import numpy as np

# A CPU driver takes all processors unless told otherwise: the processes share them.
os.environ.setdefault("LP_NUM_THREADS", str(max(1, (os.cpu_count() or 1) // int(os.environ["LOCAL_WORLD_SIZE"]))))

import torch
import torch.distributed as dist

import cmpg
import cmpg.torch

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 60
folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "out/distributed")
box = pathlib.Path(__file__).resolve().parents[2] / "scenes/box"
name = "painting.baseColor"

dist.init_process_group("gloo")
rank, count = dist.get_rank(), dist.get_world_size()
scene = cmpg.Scene(box / "scene.gltf")
truth = torch.from_numpy(np.asarray(scene[name].values))
target = torch.from_numpy(np.asarray(cmpg.Renderer(scene, max_depth=4).render(width=64, spp=64, seed=1)))  # the same in all
texture = torch.full_like(truth, 0.5, requires_grad=True)
optimizer = torch.optim.Adam([texture], lr=0.03)
for step in range(steps):
    image = cmpg.torch.render(scene, {name: texture}, width=64, spp=8, seed=2 + step * count + rank, max_depth=4)
    loss = torch.nn.functional.mse_loss(image, target)
    optimizer.zero_grad()
    loss.backward()
    dist.all_reduce(texture.grad)  # gloo sums
    texture.grad /= count
    optimizer.step()
    with torch.no_grad():
        texture.clamp_(0, 1)
    error = (texture.detach() - truth).square().mean().sqrt()
    print(f"process {rank}, step {step}: loss of its image {loss:.3g}, error of a texel {error:.4f}", flush=True)

same = [torch.empty_like(truth) for _ in range(count)]
dist.all_gather(same, texture.detach())
assert all(torch.equal(other, same[0]) for other in same)
if rank == 0:
    folder.mkdir(parents=True, exist_ok=True)
    scene[name] = texture.detach().numpy()
    scene[name].values.save(folder / "painting.png")
    print(f"wrote {folder}")
dist.destroy_process_group()
