"""glTF 2.0 appendix B with KHR_materials_specular as a Mitsuba BSDF: Mitsuba has no plugin with this mix."""
import math

import drjit as dr
import mitsuba as mi


def smith(c, a2):
    """G1(c) / (2 c) for GGX, so that the product over both directions is appendix B's visibility V without its 4 nl nv."""
    return 1 / (c + dr.sqrt(a2 + (1 - a2) * c * c))


def anisotropic_layer(at, ab, wi, wo, h):
    """D G / (4 nl nv) of GGX with alpha at along x and ab along y."""
    d = 1 / (dr.pi * at * ab * dr.square(dr.square(h.x / at) + dr.square(h.y / ab) + dr.square(h.z)))
    masking = lambda w: 2 / (1 + dr.sqrt(1 + (dr.square(at * w.x) + dr.square(ab * w.y)) / dr.square(w.z)))
    return d * masking(wi) * masking(wo) / (4 * wi.z * wo.z)


def sheen_layer(roughness, ni, no, nh):
    """KHR_materials_sheen: sheenDistribution * sheenVisibility."""
    alpha = roughness * roughness
    smooth = dr.square(1 - alpha)
    a, b, c, d, e = (rough + (sharp - rough) * smooth for rough, sharp in ((21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801), (-1.97760, -1.27393), (-4.32054, -4.85967)))
    l = lambda x: a / (1 + b * dr.power(x, c)) + d * x + e
    middle = l(mi.Float(0.5))
    masking = lambda w: dr.exp(dr.select(w < 0.5, l(dr.maximum(w, 1e-6)), 2 * middle - l(dr.maximum(1 - w, 1e-6))))
    distribution = (2 + 1 / alpha) * dr.power(dr.maximum(1 - nh * nh, 1e-12), 0.5 / alpha) / (2 * dr.pi)
    return distribution / ((1 + masking(ni) + masking(no)) * 4 * ni * no)


# E of shaders/lib/lobes/sheen.glsl: for each power of (cos / roughness)^0.4 a polynomial of the roughness. tests/lib/sheen_test.cpp has it against integrals.
SHEEN_ALBEDO = ((-1.898581, 1.039645, -1.863226, 8.550347, -8.68429, 2.502554), (2.098156, 6.966617, -3.34984, -2.986478, 2.401042, -0.2620365),
                (-5.292371, -45.1805, 30.7133, -9.545365, 1.927037), (2.820132, 102.7681, -45.87996, 3.817944), (0.4312275, -120.5581, 37.02664),
                (-1.723504, 71.42698, -13.10593), (0.5899973, -16.57853))


def sheen_albedo(c, roughness):
    x = dr.power(dr.maximum(c, 0.002) / roughness, 0.4)
    exponent = sum(k * roughness ** j * x ** i for i, ks in enumerate(SHEEN_ALBEDO) for j, k in enumerate(ks))
    return dr.exp(exponent) / roughness


class GltfBsdf(mi.BSDF):
    """Two-sided reflection; `normal` is a texture of decoded tangent-space vectors, absent where there is no normal map."""

    slots = ("baseColor", "roughness", "metallic", "specular", "normal", "clearcoat", "clearcoatRoughness", "anisotropy", "sheenColor", "sheenRoughness")

    def __init__(self, props):
        super().__init__(props)
        self.textures = {s: props[s] for s in self.slots if s in props}
        ior = props.get("ior", 1.5)
        self.rotation = props.get("rotation", 0.0)  # of the anisotropy, from the tangent towards the bitangent
        self.f0 = ((1 - ior) / (1 + ior)) ** 2
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.DiffuseReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [flags]
        self.m_flags = flags

    def traverse(self, callback):
        for slot, texture in self.textures.items():
            callback.put(slot, texture, mi.ParamFlags.Differentiable)

    def visible(self, mapped, wi):
        """The mapped normal, tilted towards wi where it turns from it (shaders/lib/mapped_normal.glsl)."""
        least = dr.mulsign(mi.Float(0.01), wi.z)
        cosine = dr.dot(mapped, wi)
        turned = dr.mulsign(cosine, wi.z) < 0.01
        return dr.select(turned, dr.normalize(mapped + wi * (least - cosine)), mapped)

    def frame(self, si, active):
        """The shading frame, perturbed by the normal map, in coordinates of si.sh_frame."""
        t = si.to_local(si.dp_du)
        t = dr.normalize(mi.Vector3f(t.x, t.y, 0))
        b = mi.Vector3f(-t.y, t.x, 0)  # n x t; texture coordinates here are never mirrored
        z = mi.Vector3f(0, 0, 1)
        if "normal" in self.textures:
            n = dr.normalize(mi.Vector3f(self.textures["normal"].eval_3(si, active)))
            z = self.visible(dr.normalize(t * n.x + b * n.y + z * n.z), si.wi)
        elif "anisotropy" not in self.textures:
            return mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Normal3f(0, 0, 1))
        if "anisotropy" not in self.textures:
            return mi.Frame3f(z)
        along = t * math.cos(self.rotation) + b * math.sin(self.rotation)
        x = dr.normalize(along - z * dr.dot(along, z))
        return mi.Frame3f(x, dr.cross(z, x), z)

    def local(self, si, wo, active):
        """wi, wo in the perturbed frame, mirrored so that wi is above; the frame and the sign to undo it."""
        frame = self.frame(si, active)
        wi, wo = frame.to_local(si.wi), frame.to_local(wo)
        sign = dr.mulsign(mi.Float(1), dr.detach(wi.z))
        return mi.Vector3f(wi.x, wi.y, wi.z * sign), mi.Vector3f(wo.x, wo.y, wo.z * sign), frame, sign

    def alpha(self, si, active):
        r = self.textures["roughness"].eval_1(si, active)
        return dr.maximum(r * r, 1e-3)

    def alphas(self, si, active):
        """Along x and y of the frame: KHR_materials_anisotropy."""
        across = self.alpha(si, active)
        if "anisotropy" not in self.textures:
            return across, across
        return across + (1 - across) * dr.square(self.textures["anisotropy"].eval_1(si, active)), across

    coat_share, sheen_share = 0.25, 0.3

    def coat_alpha(self, si, active):
        r = self.textures["clearcoatRoughness"].eval_1(si, active)
        return dr.maximum(r * r, 1e-3)

    def specular_share(self, si, active):
        metallic = dr.detach(self.textures["metallic"].eval_1(si, active))
        return metallic * 0.95 + (1 - metallic) * 0.5

    def density(self, wi, wo, alphas, share):
        h = dr.normalize(wi + wo)
        ggx = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, *alphas, True)
        return share * ggx.pdf(wi, h) / (4 * dr.dot(wo, h)) + (1 - share) * wo.z / dr.pi

    def eval(self, ctx, si, wo, active):
        wi, wo, _, _ = self.local(si, wo, active)
        active = active & (wi.z > 0) & (wo.z > 0)
        base = self.textures["baseColor"].eval(si, active)
        metallic = self.textures["metallic"].eval_1(si, active)
        specular = self.textures["specular"].eval_1(si, active)
        a2 = dr.square(self.alpha(si, active))
        h = dr.normalize(wi + wo)
        d = a2 / (dr.pi * dr.square(dr.square(h.z) * (a2 - 1) + 1))
        layer = d * smith(wi.z, a2) * smith(wo.z, a2)
        if "anisotropy" in self.textures:
            layer = anisotropic_layer(*self.alphas(si, active), wi, wo, h)
        grazing = (1 - dr.abs(dr.dot(wi, h))) ** 5
        fr = self.f0 + (1 - self.f0) * grazing
        dielectric = (1 - specular * fr) * base / dr.pi + specular * fr * layer
        metal = (base + (1 - base) * grazing) * layer
        base = dielectric * (1 - metallic) + metal * metallic
        if "sheenColor" in self.textures:  # KHR_materials_sheen
            colour, rough = self.textures["sheenColor"].eval(si, active), dr.maximum(self.textures["sheenRoughness"].eval_1(si, active), 0.07)
            albedo = dr.maximum(sheen_albedo(wi.z, rough), sheen_albedo(wo.z, rough))
            base = base * dr.maximum(1 - dr.maximum(dr.maximum(colour.x, colour.y), colour.z) * albedo, 0) + colour * sheen_layer(rough, wi.z, wo.z, h.z)
        if "clearcoat" in self.textures:  # KHR_materials_clearcoat
            a2 = dr.square(self.coat_alpha(si, active))
            d = a2 / (dr.pi * dr.square(dr.square(h.z) * (a2 - 1) + 1))
            blend = self.textures["clearcoat"].eval_1(si, active) * (0.04 + 0.96 * (1 - wi.z) ** 5)
            base = base * (1 - blend) + blend * d * smith(wi.z, a2) * smith(wo.z, a2)
        return dr.select(active, base * wo.z, 0)

    def pdf(self, ctx, si, wo, active):
        wi, wo, _, _ = self.local(si, wo, active)
        active = active & (wi.z > 0) & (wo.z > 0)
        density = self.density(wi, wo, self.alphas(si, active), self.specular_share(si, active))
        if "sheenColor" in self.textures:
            density = (1 - self.sheen_share) * density + self.sheen_share * wo.z / dr.pi
        if "clearcoat" in self.textures:
            ggx = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, dr.detach(self.coat_alpha(si, active)), True)
            h = dr.normalize(wi + wo)
            density = (1 - self.coat_share) * density + self.coat_share * ggx.pdf(wi, h) / (4 * dr.dot(wo, h))
        return dr.select(active, density, 0)

    def eval_pdf(self, ctx, si, wo, active):
        return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    def sample(self, ctx, si, sample1, sample2, active):
        wi, _, frame, sign = self.local(si, si.wi, active)
        active = active & (wi.z > 0)
        share, alphas = self.specular_share(si, active), [dr.detach(a) for a in self.alphas(si, active)]
        if "clearcoat" in self.textures:  # the first numbers go to the coat
            coat = sample1 < self.coat_share
            sample1 = dr.select(coat, 0, (sample1 - self.coat_share) / (1 - self.coat_share))
            share = dr.select(coat, 1, share)
            alphas = [dr.select(coat, dr.detach(self.coat_alpha(si, active)), a) for a in alphas]
        if "sheenColor" in self.textures:
            if "clearcoat" in self.textures:
                raise NotImplementedError("a coat over a sheen")
            share = share * (1 - self.sheen_share)  # what is left of the diffuse numbers goes to the sheen, as diffuse directions
        ggx = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, *alphas, True)
        m, _ = ggx.sample(wi, sample2)
        wo = dr.select(sample1 < share, mi.reflect(wi, m), mi.warp.square_to_cosine_hemisphere(sample2))
        active = active & (wo.z > 0)
        bs = mi.BSDFSample3f()
        bs.wo = dr.detach(frame.to_world(mi.Vector3f(wo.x, wo.y, wo.z * sign)))
        bs.eta = 1.0
        bs.sampled_component = mi.UInt32(0)
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active = active & (bs.pdf > 0)
        return bs, dr.select(active, value / bs.pdf, 0) & active

    def eval_diffuse_reflectance(self, si, active):
        return self.textures["baseColor"].eval(si, active)

    def to_string(self):
        return "GltfBsdf[]"


def register():
    mi.register_bsdf("gltf", lambda props: GltfBsdf(props))
