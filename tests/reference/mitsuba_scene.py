"""Translates the glTF subset of the bundled scenes into a Mitsuba scene, and names its parameters as we do."""
import json
import math
import pathlib
import tempfile

import drjit as dr
import mitsuba as mi
import numpy as np


def srgb_decode(x):
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


class Translation:
    """`scene`: the Mitsuba scene; parameter(name): where it keeps one of our parameters."""

    def __init__(self, folder, width, height, camera=None, exact=False, materials=None):
        """exact: every material through GltfBsdf, needed for derivatives of slots that Mitsuba's own plugins lack.

        materials: by name, what to put in the place of the file's, as make_lobes.py describes materials.
        """
        self.folder, self.exact, self.owners, self.other = pathlib.Path(folder), exact, {}, materials or {}
        self.gltf = json.loads((self.folder / "scene.gltf").read_text())
        self.data = (self.folder / self.gltf["buffers"][0]["uri"]).read_bytes()
        self.extras = self.gltf["scenes"][0]["extras"]
        self.max_depth = self.extras["maxDepth"]
        bsdfs = [self.bsdf(m) for m in self.gltf["materials"]]
        emissions = [self.emission(m) for m in self.gltf["materials"]]
        scene = {"type": "scene", "sensor": self.sensor(camera, width, height)}
        with tempfile.TemporaryDirectory() as folder:
            for i, mesh in enumerate(self.gltf["meshes"]):
                scene[f"mesh{i}"] = self.shape(mesh, bsdfs, emissions, pathlib.Path(folder) / f"{i}.ply")
            if "environment" in self.extras:
                scene["environment"] = self.environment(self.extras["environment"])
            self.scene = mi.load_dict(scene)

    def integrator(self, max_depth=None):
        # Roulette never starts: every path goes on to the depth limit, as ours does.
        return mi.load_dict({"type": "prb", "max_depth": max_depth or self.max_depth, "rr_depth": 1 << 20})

    def parameter(self, name):
        """(mi.traverse result, key) of e.g. "painting.baseColor"."""
        owner, path = self.owners[name]
        parameters = mi.traverse(owner)
        for key in (path + ".data", path + ".value", "data", "value"):
            if key in parameters:
                return parameters, key
        raise KeyError(f"{name}: no {path} in\n{parameters}")

    def image(self, index, linear):
        """Linear floats of a texture's image."""
        image = self.gltf["images"][self.gltf["textures"][index]["source"]]
        bitmap = mi.Bitmap(str(self.folder / image["uri"]))
        values = np.array(bitmap, dtype=np.float64)
        if bitmap.component_format() == mi.Struct.Type.UInt8:
            values /= 255
            if not linear:
                values = srgb_decode(values)
        return values.reshape(*values.shape[:2], -1)[:, :, :3]

    def texture(self, reference, values):
        sampler = self.gltf["samplers"][self.gltf["textures"][reference["index"]]["sampler"]]
        wrap = {33071: "clamp", 10497: "repeat", 33648: "mirror"}[sampler["wrapS"]]
        return {"type": "bitmap", "data": mi.TensorXf(np.ascontiguousarray(values, dtype=np.float32)), "raw": True,
                "filter_type": "nearest" if sampler["magFilter"] == 9728 else "bilinear", "wrap_mode": wrap}

    def colour(self, factor, reference):
        if reference is None:
            return {"type": "rgb", "value": [float(f) for f in factor]}
        return self.texture(reference, self.image(reference["index"], False) * np.array(factor))

    def scalar(self, factor, reference, channel):
        if reference is None:
            return {"type": "uniform", "value": float(factor)}
        return self.texture(reference, self.image(reference["index"], True)[:, :, channel:channel + 1] * factor)

    def bsdf(self, material):
        pbr = material["pbrMetallicRoughness"]
        extension = material.get("extensions", {})
        specular = extension.get("KHR_materials_specular", {}).get("specularFactor", 1)
        metallic, name = pbr.get("metallicFactor", 1), material["name"]
        base = self.colour(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3], pbr.get("baseColorTexture"))
        mr = pbr.get("metallicRoughnessTexture")
        rough = self.scalar(pbr.get("roughnessFactor", 1), mr, 1)
        other = self.other.get(name) or self.glass(material, specular)
        coat = other if other is not None and other["model"] == "clearcoat" else None
        brushed = other if other is not None and other["model"] == "anisotropy" else None
        velvet = other if other is not None and other["model"] == "sheen" else None
        if other is not None and coat is None and brushed is None and velvet is None:
            return self.boundary(name, other, base if pbr.get("baseColorTexture") else None)
        plain = mr is None and "normalTexture" not in material and not self.exact and coat is None and brushed is None and velvet is None
        if plain and metallic == 0 and specular == 0:
            bsdf = mi.load_dict({"type": "twosided", "nested": {"type": "diffuse", "reflectance": base}})
            self.owners[name + ".baseColor"] = bsdf, "brdf_0.reflectance"
            return bsdf
        if plain and metallic == 1:
            bsdf = mi.load_dict({"type": "twosided", "nested": {"type": "principled", "base_color": base, "roughness": rough,
                                                               "metallic": 1.0}})
            self.owners[name + ".baseColor"] = bsdf, "brdf_0.base_color"
            self.owners[name + ".roughness"] = bsdf, "brdf_0.roughness"
            return bsdf
        result = {"type": "gltf", "baseColor": base, "roughness": rough, "metallic": self.scalar(metallic, mr, 2),
                  "specular": self.scalar(specular, None, 0),
                  "ior": extension.get("KHR_materials_ior", {}).get("ior", 1.5)}
        if coat is not None:
            result.update({slot: self.scalar(coat[slot], None, 0) for slot in ("clearcoat", "clearcoatRoughness")})
        if brushed is not None:
            result.update(anisotropy=self.scalar(brushed["anisotropy"], None, 0), rotation=brushed["rotation"])
        if velvet is not None:
            result.update(sheenColor=self.colour(velvet["sheenColor"], None), sheenRoughness=self.scalar(velvet["sheenRoughness"], None, 0))
        if "normalTexture" in material:
            reference = material["normalTexture"]
            scale = reference.get("scale", 1)
            result["normal"] = self.texture(reference, (2 * self.image(reference["index"], True) - 1) * [scale, scale, 1])
        result = {k: mi.load_dict(v) if isinstance(v, dict) else v for k, v in result.items()}
        bsdf = mi.load_dict(result)
        for slot in ("baseColor", "roughness", "metallic", "specular", "normal", "clearcoat", "clearcoatRoughness", "anisotropy", "sheenColor", "sheenRoughness"):
            if slot in result:
                self.owners[f"{name}.{slot}"] = bsdf, slot
        return bsdf

    @staticmethod
    def glass(material, specular):
        """KHR_materials_transmission, smooth."""
        extensions = material.get("extensions", {})
        if "KHR_materials_transmission" not in extensions:
            return None
        solid = extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0) > 0
        return {"model": "dielectric" if solid else "thindielectric", "colour": material["pbrMetallicRoughness"]["baseColorFactor"][:3],
                "specular": [specular] * 3, "ior": extensions.get("KHR_materials_ior", {}).get("ior", 1.5)}

    def boundary(self, name, m, texture):
        """One of Mitsuba's plugins; its colours and alpha are our slots."""
        plain = lambda value: {"type": "rgb", "value": [float(v) for v in value]}
        colour = texture or plain(m["colour"])
        d = {"type": ("rough" if "alpha" in m else "") + m["model"]}
        if "alpha" in m:
            d.update(alpha=m["alpha"], distribution=m["distribution"])
        if m["model"] == "conductor":
            d.update(eta=plain(m["eta"]), k=plain(m["k"]), specular_reflectance=colour)
            keys = {"baseColor": "specular_reflectance"}
        elif m["model"] == "plastic":
            d.update(int_ior=m["ior"], ext_ior=1.0, specular_reflectance=plain(m["specular"]), diffuse_reflectance=colour, nonlinear=m["nonlinear"])
            keys = {"baseColor": "diffuse_reflectance", "specular": "specular_reflectance"}
        else:
            d.update(int_ior=m["ior"], ext_ior=1.0, specular_reflectance=plain(m["specular"]), specular_transmittance=colour)
            keys = {"baseColor": "specular_transmittance", "specular": "specular_reflectance"}
        keys["roughness"] = "alpha"
        prefix = ""
        if m["model"] in ("conductor", "plastic"):
            d, prefix = {"type": "twosided", "nested": d}, "brdf_0."
        bsdf = mi.load_dict(d)
        for slot, key in keys.items():
            self.owners[f"{name}.{slot}"] = bsdf, prefix + key
        return bsdf

    def emission(self, material):
        """One texture object per emitting material, shared by all its shapes; None where nothing is emitted."""
        if not any(material.get("emissiveFactor", [0])):
            return None
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        factor, reference = material["emissiveFactor"], material.get("emissiveTexture")
        if reference is not None:
            radiance = mi.load_dict(self.colour([strength * f for f in factor], reference))
        else:
            # A free-standing rgb texture refuses values above 1 at load, not later.
            radiance = mi.load_dict(self.colour(factor, None))
            parameters = mi.traverse(radiance)
            parameters["value"] = mi.Color3f([strength * f for f in factor])
            parameters.update()
        self.owners[material["name"] + ".emission"] = radiance, ""
        return radiance

    def accessor(self, index):
        a = self.gltf["accessors"][index]
        kind = {5126: np.float32, 5125: np.uint32}[a["componentType"]]
        components = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
        offset = self.gltf["bufferViews"][a["bufferView"]]["byteOffset"]
        return np.frombuffer(self.data, kind, a["count"] * components, offset).reshape(-1, components)

    def shape(self, mesh, bsdfs, emissions, file):
        (primitive,) = mesh["primitives"]
        attributes = {k: self.accessor(v) for k, v in primitive["attributes"].items()}
        faces = self.accessor(primitive["indices"]).reshape(-1, 3)
        made = mi.Mesh("mesh", len(attributes["POSITION"]), len(faces), has_vertex_normals="NORMAL" in attributes,
                       has_vertex_texcoords="TEXCOORD_0" in attributes)
        parameters = mi.traverse(made)
        parameters["vertex_positions"] = mi.Float(attributes["POSITION"].ravel())
        parameters["faces"] = mi.UInt32(faces.ravel())
        if "NORMAL" in attributes:
            parameters["vertex_normals"] = mi.Float(attributes["NORMAL"].ravel())
        if "TEXCOORD_0" in attributes:
            parameters["vertex_texcoords"] = mi.Float(attributes["TEXCOORD_0"].ravel())
        parameters.update()
        made.write_ply(str(file))
        result = {"type": "ply", "filename": str(file), "face_normals": "NORMAL" not in attributes,
                  "bsdf": bsdfs[primitive["material"]]}
        if emissions[primitive["material"]] is not None:
            result["emitter"] = {"type": "area", "radiance": emissions[primitive["material"]]}
        return result

    def environment(self, extras):
        environment = mi.load_dict({
            "type": "envmap", "filename": str(self.folder / extras["uri"]), "scale": extras.get("intensity", 1),
            "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], math.degrees(extras.get("rotation", 0)))})
        self.owners["environment.radiance"] = environment, ""
        return environment

    def sensor(self, name, width, height):
        cameras = self.gltf["cameras"]
        index = 0 if name is None else [c["name"] for c in cameras].index(name)
        node = next(n for n in self.gltf["nodes"] if n.get("camera") == index)
        # Columns in the file; Mitsuba's camera looks along +z with x to the left.
        matrix = np.array(node["matrix"]).reshape(4, 4).T @ np.diag([-1, 1, -1, 1])
        return {"type": "perspective", "fov": math.degrees(cameras[index]["perspective"]["yfov"]), "fov_axis": "y",
                "near_clip": 1e-3, "far_clip": 1e4, "to_world": mi.ScalarTransform4f(matrix),
                "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                         "pixel_format": "rgb", "component_format": "float32"},
                "sampler": {"type": "independent"}}
