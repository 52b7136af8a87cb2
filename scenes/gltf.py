"""Meshes and a glTF 2.0 writer small enough to read: what the scene generator builds on."""
import array
import json
import math
import pathlib

FLOAT, UINT = 5126, 5125
VERTICES, INDICES = 34962, 34963
NEAREST, LINEAR, CLAMP, REPEAT = 9728, 9729, 33071, 10497


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def normalise(a):
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return (a[0] / length, a[1] / length, a[2] / length)


class Mesh:
    """Triangles; without normals they are flat, as glTF says. Front faces wind counter-clockwise."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.indices = [], [], [], []

    def quad(self, a, b, c, d):
        """Corners counter-clockwise seen from the front; the picture's lower left corner lies at a."""
        base = len(self.positions)
        self.positions += [a, b, c, d]
        self.uvs += [(0, 1), (1, 1), (1, 0), (0, 0)]
        self.indices += [base, base + 1, base + 2, base, base + 2, base + 3]
        return self

    def box(self, low, high, without=""):
        """Faces point outwards; `without` names sides to leave out, e.g. "y-"."""
        (x, y, z), (X, Y, Z) = low, high
        sides = {
            "x-": ((x, y, z), (x, y, Z), (x, Y, Z), (x, Y, z)),
            "x+": ((X, y, Z), (X, y, z), (X, Y, z), (X, Y, Z)),
            "y-": ((x, y, z), (X, y, z), (X, y, Z), (x, y, Z)),
            "y+": ((x, Y, Z), (X, Y, Z), (X, Y, z), (x, Y, z)),
            "z-": ((X, y, z), (x, y, z), (x, Y, z), (X, Y, z)),
            "z+": ((x, y, Z), (X, y, Z), (X, Y, Z), (x, Y, Z)),
        }
        for side, corners in sides.items():
            if side not in without:
                self.quad(*corners)
        return self

    def surface(self, point, columns, rows, smooth=True):
        """point(u, v) on a grid over the unit square; normals by central differences, dP/du x dP/dv outwards."""
        base, e = len(self.positions), 1e-4
        for j in range(rows + 1):
            for i in range(columns + 1):
                u, v = i / columns, j / rows
                self.positions.append(point(u, v))
                self.uvs.append((u, 1 - v))
                if smooth:
                    # Step inwards at poles, where dP/du vanishes.
                    w = min(max(v, 2 * e), 1 - 2 * e)
                    du = sub(point(u + e, w), point(u - e, w))
                    dv = sub(point(u, w + e), point(u, w - e))
                    self.normals.append(normalise(cross(du, dv)))
        for j in range(rows):
            for i in range(columns):
                a = base + j * (columns + 1) + i
                b, c, d = a + 1, a + columns + 2, a + columns + 1
                for triangle in ((a, b, c), (a, c, d)):
                    corners = [self.positions[k] for k in triangle]
                    if len(set(corners)) == 3:  # no slivers at poles
                        self.indices += triangle
        return self

    def sphere(self, centre, radius, columns=48, rows=24):
        def point(u, v):
            theta, phi = math.pi * v, 2 * math.pi * u
            if v in (0, 1):
                return (centre[0], centre[1] - radius * (1 - 2 * v), centre[2])
            if u == 1:
                phi = 0
            return (centre[0] + radius * math.sin(theta) * math.cos(phi), centre[1] - radius * math.cos(theta),
                    centre[2] - radius * math.sin(theta) * math.sin(phi))
        return self.surface(point, columns, rows)

    def transform(self, matrix, offset=(0, 0, 0)):
        """Rotation or uniform scale by rows of `matrix`, then a shift."""
        def turn(p):
            return tuple(sum(m * c for m, c in zip(row, p)) for row in matrix)
        self.positions = [tuple(c + o for c, o in zip(turn(p), offset)) for p in self.positions]
        self.normals = [normalise(turn(n)) for n in self.normals]
        return self

    def shift(self, offset):
        return self.transform(((1, 0, 0), (0, 1, 0), (0, 0, 1)), offset)

    def merge(self, other):
        base = len(self.positions)
        self.positions += other.positions
        self.normals += other.normals
        self.uvs += other.uvs
        self.indices += [base + i for i in other.indices]
        return self

    def used(self):
        """Without the vertices that no triangle uses: poles have one too many."""
        order = sorted(set(self.indices))
        place = {old: new for new, old in enumerate(order)}
        result = Mesh()
        result.positions = [self.positions[i] for i in order]
        result.normals = [self.normals[i] for i in order] if self.normals else []
        result.uvs = [self.uvs[i] for i in order] if self.uvs else []
        result.indices = [place[i] for i in self.indices]
        return result


def rotation(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return {"x": ((1, 0, 0), (0, c, -s), (0, s, c)), "y": ((c, 0, s), (0, 1, 0), (-s, 0, c)),
            "z": ((c, -s, 0), (s, c, 0), (0, 0, 1))}[axis]


class Gltf:
    """One scene: materials, meshes, cameras; write() makes scene.gltf, scene.bin and the images."""

    def __init__(self, max_depth):
        self.files, self.data, self.material_index = {}, bytearray(), {}
        self.root = {"asset": {"version": "2.0", "generator": "cmpg-vk scenes/generate.py"}, "scene": 0,
                     "scenes": [{"nodes": [], "extras": {"maxDepth": max_depth}}]}

    def append(self, key, item):
        items = self.root.setdefault(key, [])
        items.append(item)
        return len(items) - 1

    def use_extension(self, name):
        used = self.root.setdefault("extensionsUsed", [])
        if name not in used:
            used.append(name)

    def texture(self, file, content, nearest=False, wrap=CLAMP, linear=False):
        self.files[file] = content
        sampler = {"magFilter": NEAREST if nearest else LINEAR, "minFilter": NEAREST if nearest else LINEAR,
                   "wrapS": wrap, "wrapT": wrap}
        image = {"uri": file}
        if linear:
            image["extras"] = {"colorSpace": "linear"}
        return self.append("textures", {"sampler": self.append("samplers", sampler), "source": self.append("images", image)})

    def material(self, name, colour=(1, 1, 1), texture=None, metallic=0, roughness=1, specular=0, emission=None,
                 emission_texture=None, rough_texture=None, normal_texture=None, normal_scale=1, glass=None, ior=None):
        """metallic 0 with specular 0 (the default) is Lambert colour/pi; glass: "pane" or "solid", with specular 1."""
        pbr = {"baseColorFactor": [*colour, 1], "metallicFactor": metallic, "roughnessFactor": roughness}
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        if rough_texture is not None:
            pbr["metallicRoughnessTexture"] = {"index": rough_texture}
        item = {"name": name, "pbrMetallicRoughness": pbr}
        if normal_texture is not None:
            item["normalTexture"] = {"index": normal_texture, "scale": normal_scale}
        extensions = {}
        if specular != 1 and (metallic != 1 or rough_texture is not None):  # all metal has no dielectric part
            extensions["KHR_materials_specular"] = {"specularFactor": specular}
        if glass is not None:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": 1}
            if glass == "solid":
                extensions["KHR_materials_volume"] = {"thicknessFactor": 1}
        if ior is not None:
            extensions["KHR_materials_ior"] = {"ior": ior}
        if emission is not None:
            strength = max(*emission, 1)  # emissiveFactor may not exceed 1
            item["emissiveFactor"] = [e / strength for e in emission]
            if strength > 1:
                extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
            if emission_texture is not None:
                item["emissiveTexture"] = {"index": emission_texture}
        if extensions:
            item["extensions"] = extensions
            for extension in extensions:
                self.use_extension(extension)
        self.material_index[name] = self.append("materials", item)

    def accessor(self, values, kind, components, target):
        while len(self.data) % 4:
            self.data.append(0)
        packed = array.array("f" if kind == FLOAT else "I", values)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": 4 * len(packed), "target": target}
        self.data += packed.tobytes()
        names = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
        item = {"bufferView": self.append("bufferViews", view), "componentType": kind,
                "count": len(packed) // components, "type": names[components]}
        if components == 3 and target == VERTICES:
            item["min"] = [min(packed[c::3]) for c in range(3)]
            item["max"] = [max(packed[c::3]) for c in range(3)]
        return self.append("accessors", item)

    def mesh(self, name, mesh, material):
        mesh = mesh.used()
        textured = any("index" in t for t in self._textures(material))
        attributes = {"POSITION": self.accessor([c for p in mesh.positions for c in p], FLOAT, 3, VERTICES)}
        if mesh.normals:
            attributes["NORMAL"] = self.accessor([c for n in mesh.normals for c in n], FLOAT, 3, VERTICES)
        if textured:
            attributes["TEXCOORD_0"] = self.accessor([c for t in mesh.uvs for c in t], FLOAT, 2, VERTICES)
        primitive = {"attributes": attributes, "indices": self.accessor(mesh.indices, UINT, 1, INDICES),
                     "material": self.material_index[material]}
        index = self.append("meshes", {"name": name, "primitives": [primitive]})
        self.node({"name": name, "mesh": index})

    def _textures(self, material):
        item = self.root["materials"][self.material_index[material]]
        pbr = item["pbrMetallicRoughness"]
        return [t for t in (pbr.get("baseColorTexture"), pbr.get("metallicRoughnessTexture"),
                            item.get("normalTexture"), item.get("emissiveTexture")) if t]

    def camera(self, name, eye, target, yfov_degrees, aspect=1):
        perspective = {"yfov": math.radians(yfov_degrees), "aspectRatio": aspect, "znear": 0.01}
        index = self.append("cameras", {"name": name, "type": "perspective", "perspective": perspective})
        z = normalise(sub(eye, target))
        x = normalise(cross((0, 1, 0), z))
        y = cross(z, x)
        self.node({"name": name, "camera": index, "matrix": [*x, 0, *y, 0, *z, 0, *eye, 1]})

    def node(self, node):
        self.root["scenes"][0]["nodes"].append(self.append("nodes", node))

    def environment(self, file, content, intensity=1.0, rotation_radians=0.0):
        self.files[file] = content
        self.root["scenes"][0]["extras"]["environment"] = {"uri": file, "intensity": intensity, "rotation": rotation_radians}

    def triangles(self):
        return sum(a["count"] // 3 for a in self.root["accessors"] if a["componentType"] == UINT)

    def write(self, folder):
        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        self.root["buffers"] = [{"uri": "scene.bin", "byteLength": len(self.data)}]
        for file, content in self.files.items():
            (folder / file).write_bytes(content)
        (folder / "scene.bin").write_bytes(self.data)
        (folder / "scene.gltf").write_text(json.dumps(self.root, indent=1) + "\n")
