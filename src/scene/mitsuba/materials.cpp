// BSDFs of a Mitsuba scene become materials, their properties parameters by the names that Mitsuba's users write.
#include "scene/mitsuba/load.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr const char* kSupported = "diffuse, dielectric, roughdielectric, thindielectric, conductor, roughconductor, plastic, roughplastic, principled, blendbsdf, twosided or mask";

// What stands around a BSDF: adapters that are no lobe themselves.
struct Wrapped {
    explicit Wrapped(MitsubaObject object) : bsdf(std::move(object)) {}

    MitsubaObject bsdf; // the innermost
    bool twosided = false;
    std::optional<MitsubaObject> mask;
    std::string id; // of the outermost that has one
};

Wrapped unwrap(MitsubaLoad& load, const MitsubaObject& outermost) {
    Wrapped w(outermost);
    for (int depth = 0; depth < 8; ++depth) {
        if (w.id.empty())
            w.id = w.bsdf.id();
        const bool twosided = w.bsdf.type() == "twosided", mask = w.bsdf.type() == "mask";
        if (!twosided && !mask)
            return w;
        const std::vector<MitsubaObject> nested = w.bsdf.objects("bsdf");
        if (nested.size() != 1)
            w.bsdf.fail(w.bsdf.title() + " has " + std::to_string(nested.size()) + " materials; one is supported",
                        nested.size() == 2 ? "front and back differ" : "", "give it one bsdf");
        if (mask && w.mask)
            w.bsdf.fail("a mask within a mask is not supported");
        if (mask)
            w.mask = w.bsdf;
        w.twosided |= twosided;
        const MitsubaObject inner = nested.front();
        if (twosided)
            load.noteUnread(w.bsdf);
        w.bsdf = inner;
    }
    outermost.fail("materials are nested too deeply", "", "at most 8 levels are read");
}

double indexOf(const MitsubaObject& bsdf, const char* name, const char* fallback) {
    const MitsubaElement* e = bsdf.find(name);
    if (!e || e->tag == "string") {
        const std::string text = bsdf.string(name, fallback);
        const std::optional<double> index = dielectricIndex(text);
        if (!index)
            bsdf.document().fail(*e, "no index of refraction is known for \"" + text.substr(0, 64) + "\"", "", "give it as <float>");
        return *index;
    }
    return bsdf.real(name, 0, 0.1, 10);
}

class MaterialMaker {
  public:
    MaterialMaker(MitsubaLoad& load, Material& material) : load_(load), material_(material) {}

    void leaf(const MitsubaObject& bsdf);
    void nothing();
    void blend(const MitsubaObject& bsdf, const Material& first, const Material& second);
    void mask(const MitsubaObject& mask);
    // A slot that has no property in Mitsuba, or keeps its default.
    void constant(SlotKind kind, std::uint32_t channels, glm::vec3 value, const char* property = "") {
        load_.addSlot(material_, kind, channels, value, property);
    }
    void slot(SlotKind kind, std::uint32_t channels, const MitsubaObject& owner, const char* property, glm::vec3 fallback, const std::string& name = {});

  private:
    void diffuse(const MitsubaObject& bsdf);
    void dielectric(const MitsubaObject& bsdf, bool rough, bool thin);
    void conductor(const MitsubaObject& bsdf, bool rough);
    void plastic(const MitsubaObject& bsdf, bool rough);
    void principled(const MitsubaObject& bsdf);
    void roughness(const MitsubaObject& bsdf, bool rough);

    MitsubaLoad& load_;
    Material& material_;
};

void MaterialMaker::slot(SlotKind kind, std::uint32_t channels, const MitsubaObject& owner, const char* property, glm::vec3 fallback,
                         const std::string& name) {
    const MitsubaElement* e = owner.find(property);
    const MitsubaElement* target = e ? &load_.document.resolve(*e) : nullptr;
    const bool emission = kind == SlotKind::Emission;
    if (target && !target->isObject()) {
        fallback = glm::vec3(mitsubaColor(load_.document, *target, emission));
        if (channels == 1 && (fallback.x != fallback.y || fallback.y != fallback.z))
            load_.document.fail(*target, "the property " + std::string(property) + " must be a number");
    }
    Parameter& p = load_.addSlot(material_, kind, channels, fallback, name.empty() ? property : name);
    if (target && target->isObject()) {
        if (target->tag != "texture")
            load_.document.fail(*target, "<" + target->tag + "> is no colour", "", "use rgb, float, or a texture");
        MitsubaTexture texture = readMitsubaTexture(load_, MitsubaObject(load_.document, *target));
        if (channels == 1)
            texture = scalarTexture(std::move(texture));
        load_.fillTexels(p, texture.image, texture.address, {.srgb = texture.srgb});
    }
    load_.origins[p.name] = {&owner.element(), property};
    const auto index = std::uint32_t(load_.scene.parameters.size() - 1);
    // As Mitsuba's own list of parameters has it.
    for (const char* within : {"", "brdf_0.", "nested_bsdf."})
        if (const std::size_t dot = p.name.rfind('.'); !emission || *within == 0)
            for (const char* ending : {"", ".value", ".data"})
                load_.scene.aliases.try_emplace(p.name.substr(0, dot + 1) + within + p.name.substr(dot + 1) + ending, index);
}

void MaterialMaker::roughness(const MitsubaObject& bsdf, bool rough) {
    material_.smooth = !rough;
    if (!rough)
        return constant(SlotKind::Roughness, 1, glm::vec3(0));
    material_.microfacets = bsdf.oneOf("distribution", {"beckmann", "ggx"}) == "ggx" ? Microfacets::Ggx : Microfacets::Beckmann;
    bsdf.ignore({"sample_visible"});
    const MitsubaElement *u = bsdf.find("alpha_u"), *v = bsdf.find("alpha_v");
    if (const MitsubaElement* e = u ? u : v) {
        if (material_.model == SurfaceModel::Plastic)
            load_.document.fail(*e, "the coat of a plastic has one roughness", "Mitsuba's own has no other", "give alpha");
        if (!u || !v)
            load_.document.fail(*e, "alpha_u and alpha_v go together", "", "give both, or alpha for both directions");
        if (const MitsubaElement* both = bsdf.find("alpha"))
            load_.document.fail(*both, "alpha stands beside alpha_u and alpha_v", "", "give either");
        slot(SlotKind::Anisotropy, 1, bsdf, "alpha_u", glm::vec3(0.1f));
        return slot(SlotKind::Roughness, 1, bsdf, "alpha_v", glm::vec3(0.1f));
    }
    slot(SlotKind::Roughness, 1, bsdf, "alpha", glm::vec3(0.1f));
}

void MaterialMaker::diffuse(const MitsubaObject& bsdf) {
    slot(SlotKind::BaseColor, 3, bsdf, "reflectance", glm::vec3(0.5f));
    constant(SlotKind::Roughness, 1, glm::vec3(1));
    constant(SlotKind::Metallic, 1, glm::vec3(0));
    constant(SlotKind::Specular, 1, glm::vec3(0));
}

void MaterialMaker::dielectric(const MitsubaObject& bsdf, bool rough, bool thin) {
    material_.model = thin ? SurfaceModel::ThinDielectric : SurfaceModel::Dielectric;
    material_.ior = float(indexOf(bsdf, "int_ior", "bk7") / indexOf(bsdf, "ext_ior", "air"));
    slot(SlotKind::BaseColor, 3, bsdf, "specular_transmittance", glm::vec3(1));
    roughness(bsdf, rough);
    constant(SlotKind::Metallic, 1, glm::vec3(0));
    slot(SlotKind::Specular, 3, bsdf, "specular_reflectance", glm::vec3(1));
}

void MaterialMaker::conductor(const MitsubaObject& bsdf, bool rough) {
    material_.model = SurfaceModel::Conductor;
    const ConductorIndex relative = conductorIndex(bsdf);
    material_.eta = relative.eta;
    material_.k = relative.k;
    slot(SlotKind::BaseColor, 3, bsdf, "specular_reflectance", glm::vec3(1));
    roughness(bsdf, rough);
    constant(SlotKind::Metallic, 1, glm::vec3(1));
    constant(SlotKind::Specular, 1, glm::vec3(1));
}

void MaterialMaker::plastic(const MitsubaObject& bsdf, bool rough) {
    material_.model = SurfaceModel::Plastic;
    material_.ior = float(indexOf(bsdf, "int_ior", "polypropylene") / indexOf(bsdf, "ext_ior", "air"));
    material_.nonlinear = bsdf.boolean("nonlinear", false);
    slot(SlotKind::BaseColor, 3, bsdf, "diffuse_reflectance", glm::vec3(0.5f));
    roughness(bsdf, rough);
    constant(SlotKind::Metallic, 1, glm::vec3(0));
    slot(SlotKind::Specular, 3, bsdf, "specular_reflectance", glm::vec3(1));
}

void MaterialMaker::principled(const MitsubaObject& bsdf) {
    for (const char* lobe : {"spec_trans", "sheen", "clearcoat", "flatness", "spec_tint"})
        if (bsdf.find(lobe) && bsdf.real(lobe, 0) != 0)
            load_.document.fail(*bsdf.find(lobe), "the principled material's " + std::string(lobe) + " is not supported", "there is no lobe for it",
                                "leave it away");
    bsdf.ignore({"sheen_tint", "clearcoat_gloss", "diff_trans", "diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"});
    const double specular = bsdf.real("specular", 0.5, 0, 1);
    const double f0 = std::sqrt(0.08 * specular);
    material_.ior = float(bsdf.find("eta") ? bsdf.real("eta", 1.5, 1, 10) : (1 + f0) / (1 - f0));
    slot(SlotKind::BaseColor, 3, bsdf, "base_color", glm::vec3(0.5f));
    slot(SlotKind::Roughness, 1, bsdf, "roughness", glm::vec3(0.5f));
    slot(SlotKind::Metallic, 1, bsdf, "metallic", glm::vec3(0));
    if (bsdf.find("anisotropic")) {
        material_.anisotropyByAspect = true;
        slot(SlotKind::Anisotropy, 1, bsdf, "anisotropic", glm::vec3(0));
    }
    constant(SlotKind::Specular, 1, glm::vec3(1));
    const Parameter& metallic = load_.scene.parameters[material_.parameters[std::size_t(SlotKind::Metallic)]];
    if (metallic.values.size() != 1 || metallic.values[0] < 1)
        load_.warn(material_.name + ": principled is rendered as glTF's metallic-roughness, whose diffuse part differs a little from Mitsuba's");
}

void MaterialMaker::leaf(const MitsubaObject& bsdf) {
    const std::string& type = bsdf.type();
    if (type == "diffuse")
        diffuse(bsdf);
    else if (type == "dielectric" || type == "roughdielectric")
        dielectric(bsdf, type != "dielectric", false);
    else if (type == "thindielectric")
        dielectric(bsdf, false, true);
    else if (type == "conductor" || type == "roughconductor")
        conductor(bsdf, type != "conductor");
    else if (type == "plastic" || type == "roughplastic")
        plastic(bsdf, type != "plastic");
    else if (type == "principled")
        principled(bsdf);
    else
        bsdf.fail("the material " + type.substr(0, 64) + " is not supported", "", std::string("use ") + kSupported);
    load_.noteUnread(bsdf);
}

// Under light that a null surface emits: a pane that bends and reflects nothing, as it is to Mitsuba's path tracer.
void MaterialMaker::nothing() {
    material_.model = SurfaceModel::ThinDielectric;
    material_.ior = 1;
    material_.smooth = true;
    constant(SlotKind::BaseColor, 3, glm::vec3(1));
    constant(SlotKind::Roughness, 1, glm::vec3(0));
    constant(SlotKind::Metallic, 1, glm::vec3(0));
    constant(SlotKind::Specular, 3, glm::vec3(1));
}

// The first of a blend's materials becomes the blend, the second a material that it names; their parameters are those of the two.
void MaterialMaker::blend(const MitsubaObject& bsdf, const Material& first, const Material& second) {
    const std::string name = material_.name;
    material_ = first;
    material_.name = name;
    if (!bsdf.find("weight"))
        bsdf.fail("the blend has no weight", "", "give it as <float> or <texture>: the share of its second material");
    slot(SlotKind::Weight, 1, bsdf, "weight", glm::vec3(0.5f));
    Material& other = load_.scene.materials.emplace_back(second);
    other.name = name + ".second";
    for (const SlotKind kind : {SlotKind::Weight, SlotKind::Emission})
        other.parameters[std::size_t(kind)] = material_.parameters[std::size_t(kind)];
    material_.blendWith = std::uint32_t(load_.scene.materials.size() - 1);
    load_.noteUnread(bsdf);
}

void MaterialMaker::mask(const MitsubaObject& mask) {
    constexpr double kHalf = 0.5;
    const MitsubaElement* e = mask.find("opacity");
    const MitsubaElement* target = e ? &load_.document.resolve(*e) : nullptr;
    if (!target || !target->isObject()) {
        // Where Mitsuba needs a number it takes the mean of a constant colour, but the luminance of a picture's.
        const glm::dvec3 color = target ? mitsubaColor(load_.document, *target, false) : glm::dvec3(kHalf);
        material_.alphaFactor = float(std::clamp((color.x + color.y + color.z) / 3, 0.0, 1.0));
        material_.alphaMask = material_.coverage = material_.alphaFactor < 1;
    } else {
        material_.alphaMask = material_.coverage = true;
        const MitsubaTexture texture = scalarTexture(readMitsubaTexture(load_, MitsubaObject(load_.document, *target)));
        const RawImage& from = texture.image;
        RawImage opacity{from.width, from.height, 2, {}, {}, true}; // as an image with alpha
        for (std::size_t i = 0; i < from.pixels(); ++i) {
            const std::size_t at = i * from.channels;
            const float code = from.bytes.empty() ? from.values[at] : float(from.bytes[at]) / 255.0f;
            const float value = texture.srgb && !from.linear ? srgbDecode(code) : code;
            opacity.values.insert(opacity.values.end(), {value, value});
        }
        load_.addAlphaTexture(material_, opacity, texture.address);
    }
    load_.noteUnread(mask);
}

} // namespace

ConductorIndex conductorIndex(const MitsubaObject& bsdf) {
    const MitsubaDocument& document = bsdf.document();
    const std::string name = bsdf.string("material", "none");
    const std::optional<ConductorIndex> known = conductorIndex(name);
    if (!known)
        document.fail(*bsdf.find("material"), "the metal \"" + name.substr(0, 64) + "\" is not known", "",
                      "use one of " + conductorNames() + ", or give eta and k as <rgb>");
    ConductorIndex out = *known;
    const double exterior = bsdf.find("ext_eta") ? indexOf(bsdf, "ext_eta", "air") : 1;
    const auto read = [&](const char* property, glm::vec3& value) {
        const MitsubaElement* e = bsdf.find(property);
        if (!e)
            return;
        value = glm::vec3(mitsubaColor(document, *e, false));
        if (!(value.x >= 0 && value.y >= 0 && value.z >= 0 && value.x <= 100 && value.y <= 100 && value.z <= 100))
            document.fail(*e, "the property " + std::string(property) + " is outside of [0, 100]");
    };
    read("eta", out.eta);
    read("k", out.k);
    out.eta /= float(exterior);
    out.k /= float(exterior);
    return out;
}

// One of the two materials of a blend, without an id called `name`.
Material MitsubaMaterials::part(const MitsubaObject& bsdf, const MitsubaObject& blend, const std::string& name) {
    const Wrapped inner = unwrap(load_, bsdf);
    if (inner.bsdf.type() == "null")
        blend.fail("a null material within a blend is not supported", "", "use a mask around the other one");
    if (inner.mask)
        blend.fail("a mask within a blend is not supported", "", "put the mask around the blend");
    if (inner.bsdf.type() == "blendbsdf")
        blend.fail("a blend within a blend is not supported", "", "blend two materials");
    const Material material = load_.scene.materials[*of(&bsdf, nullptr, name, true)];
    // Mitsuba calls them by their place, whatever their ids.
    for (const std::uint32_t p : material.parameters) {
        if (p == kNoParameter)
            continue;
        const std::string parameter = load_.scene.parameters[p].name, property = parameter.substr(parameter.rfind('.'));
        const std::size_t dot = name.rfind('.');
        for (const std::string& outer : {name, name.substr(0, dot) + ".brdf_0" + name.substr(dot)})
            for (const char* within : {"", ".brdf_0"})
                for (const char* ending : {"", ".value", ".data"})
                    if (const std::string alias = outer + within + property + ending; alias != parameter)
                        load_.scene.aliases.try_emplace(alias, p);
    }
    return material;
}

std::optional<std::uint32_t> MitsubaMaterials::of(const MitsubaObject* bsdf, const MitsubaObject* emitter, const std::string& shape, bool named) {
    const std::pair key(bsdf ? &bsdf->element() : nullptr, emitter ? &emitter->element() : nullptr);
    if (const auto found = made_.find(key); found != made_.end())
        return found->second;
    std::optional<Wrapped> wrapped;
    if (bsdf)
        wrapped.emplace(unwrap(load_, *bsdf));
    if (wrapped && wrapped->bsdf.type() == "null" && !emitter)
        return made_[key] = std::nullopt;
    if (emitter && emitter->type() != "area")
        emitter->fail("a shape cannot emit as " + emitter->type() + " does", "", "use an area emitter");

    // Shapes that share a material share its parameters, whatever they emit.
    std::optional<std::uint32_t> like;
    if (emitter && wrapped)
        like = of(bsdf, nullptr, shape);
    Material material;
    MaterialMaker maker(load_, material);
    if (like) {
        material = load_.scene.materials[*like];
        material.name = uniqueName(material.name + " of " + shape, load_.materialNames);
    } else {
        material.name = uniqueName(!wrapped ? shape : !wrapped->id.empty() ? wrapped->id : named ? shape : shape + ".bsdf", load_.materialNames);
        if (wrapped && wrapped->bsdf.type() == "blendbsdf") {
            const std::vector<MitsubaObject> parts = wrapped->bsdf.objects("bsdf");
            if (parts.size() != 2)
                wrapped->bsdf.fail("the blend has " + std::to_string(parts.size()) + " materials", "", "give it two");
            const Material first = part(parts[0], wrapped->bsdf, material.name + ".bsdf_0"), second = part(parts[1], wrapped->bsdf, material.name + ".bsdf_1");
            maker.blend(wrapped->bsdf, first, second);
            if (wrapped->twosided)
                material.oneSided = load_.scene.materials[material.blendWith].oneSided = false;
        } else if (wrapped && wrapped->bsdf.type() != "null") {
            maker.leaf(wrapped->bsdf);
            const bool closed = material.model == SurfaceModel::Dielectric || material.model == SurfaceModel::ThinDielectric;
            material.oneSided = !wrapped->twosided && !closed;
        } else if (wrapped) {
            maker.nothing();
        } else {
            // What emits is black otherwise, unless it says more.
            material.oneSided = !emitter;
            maker.constant(SlotKind::BaseColor, 3, glm::vec3(emitter ? 0.0f : 0.5f), "reflectance");
            maker.constant(SlotKind::Roughness, 1, glm::vec3(1));
            maker.constant(SlotKind::Metallic, 1, glm::vec3(0));
            maker.constant(SlotKind::Specular, 1, glm::vec3(0));
        }
    }
    const bool blend = material.blendWith != kNoMaterial;
    if (emitter && blend) { // each emits the same
        Material second = load_.scene.materials[material.blendWith];
        second.name = material.name + ".second";
        material.blendWith = std::uint32_t(load_.scene.materials.size());
        load_.scene.materials.push_back(second);
    }
    if (emitter) {
        const std::string own = material.name;
        material.name = uniqueName(emitter->id().empty() ? shape : emitter->id(), load_.emitterNames);
        maker.slot(SlotKind::Emission, 3, *emitter, "radiance", glm::vec3(1), emitter->id().empty() ? "emitter.radiance" : "radiance");
        material.name = own;
        emitter->ignore({"sampling_weight"});
        load_.noteUnread(*emitter);
        if (blend)
            load_.scene.materials[material.blendWith].parameters[std::size_t(SlotKind::Emission)] = material.parameters[std::size_t(SlotKind::Emission)];
    } else if (!blend) {
        maker.constant(SlotKind::Emission, 3, glm::vec3(0));
    }
    if (!like && !blend)
        maker.constant(SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    if (wrapped && wrapped->mask && !like)
        maker.mask(*wrapped->mask);
    load_.scene.materials.push_back(std::move(material));
    return made_[key] = std::uint32_t(load_.scene.materials.size() - 1);
}

} // namespace cmpg
