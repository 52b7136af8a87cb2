// The options that trade speed for accuracy, and the settings of them that a measurement tries.
#include "lab/tradeoff_knobs.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace cmpg {
namespace {

template <class E, std::size_t N> std::vector<nlohmann::json> others(const EnumName<E> (&names)[N], E own) {
    std::vector<nlohmann::json> values;
    for (const auto& n : names)
        if (n.value != own)
            values.emplace_back(n.name);
    return values;
}

// Those that differ from `own` and from each other, in order.
std::vector<nlohmann::json> counts(std::uint32_t own, std::initializer_list<std::uint32_t> wanted) {
    std::vector<nlohmann::json> values;
    for (const std::uint32_t v : wanted)
        if (v > 0 && v != own && std::find(values.begin(), values.end(), nlohmann::json(v)) == values.end())
            values.emplace_back(v);
    return values;
}

std::vector<nlohmann::json> fractions(double own, std::initializer_list<double> wanted) {
    std::vector<nlohmann::json> values;
    for (const double v : wanted) {
        char text[32]; // in digits that people would write
        std::snprintf(text, sizeof text, "%.4g", v);
        if (std::strtof(text, nullptr) != float(own))
            values.emplace_back(std::strtod(text, nullptr));
    }
    return values;
}

bool matters(Knob::Needs needs, const KnobUse& use) {
    switch (needs) {
    case Knob::Needs::Steps:
        return use.steps;
    case Knob::Needs::Reverse:
        return use.reverse;
    case Knob::Needs::Guide:
        return use.guide;
    case Knob::Needs::Roulette:
        return use.roulette;
    case Knob::Needs::Nothing:
        break;
    }
    return true;
}

} // namespace

std::vector<Knob> tradeoffKnobs(const Options& o, std::uint32_t sceneDepth) {
    using Needs = Knob::Needs;
    const std::uint32_t spp = o.effectiveSpp(), gradient = o.effectiveSppGradient(), depth = o.effectiveDepth(sceneDepth), train = o.effectiveTrain();
    return {
        {"quality", others(kQualities, o.quality), "presets"},
        {"spp", counts(spp, {spp / 4, spp * 4}), "samples of the image", Needs::Steps},
        {"spp-gradient", counts(gradient, {gradient / 4, gradient * 4}), "samples of the derivative pass"},
        {"max-depth", counts(depth, {depth / 4, depth / 2, depth * 2}), "depth"},
        {"sampling", others(kSamplings, o.sampling), "sampling of directions"},
        {"guide-share", fractions(o.guideShare, {0.25, 0.5, 0.75}), "share of guided directions", Needs::Guide},
        {"cell-records", counts(o.cellRecords, {o.cellRecords / 4, o.cellRecords * 4}), "records of a cell", Needs::Guide},
        {"direction-share", fractions(o.directionShare, {o.directionShare / 4, o.directionShare * 4}), "share of a quadrant",
         Needs::Guide},
        {"train", counts(train, {train / 2, train * 2}), "learning passes", Needs::Guide},
        {"roulette", others(kRoulettes, o.roulette), "roulette and splitting", Needs::Reverse},
        {"roulette-effort", fractions(o.rouletteEffort, {0.1, 0.3, 1.0}), "effort of splitting", Needs::Roulette},
        {"pixel-sampling", others(kPixelSamplings, o.pixelSampling.value_or(PixelSampling::Adjoint)), "sampling of pixels", Needs::Reverse},
        {"sampler", others(kSamplers, o.sampler), "sampler"},
        {"no-nee", {!o.noLightSampling}, "light sampling"},
        {"positivize", {!o.positivize}, "positivization"},
    };
}

std::string KnobChange::text() const {
    std::string text = value == false ? "without --" : "--";
    text.append(option);
    if (!value.is_boolean())
        text.append(" ").append(value.is_string() ? value.get<std::string>() : value.dump());
    return text;
}

std::string Setting::name() const {
    std::string text;
    for (const KnobChange& change : changes)
        text.append(text.empty() ? "" : " ").append(change.text());
    return text.empty() ? "defaults" : text;
}

Setting makeSetting(const Options& base, std::vector<KnobChange> changes) {
    Setting setting{std::move(changes), base};
    nlohmann::json config = nlohmann::json::object();
    for (const KnobChange& change : setting.changes)
        config[change.option] = change.value;
    applyConfig(config, setting.options);
    return setting;
}

std::vector<Setting> singleSettings(const Options& base, std::uint32_t depth, const KnobUse& use, std::vector<std::string>& unused) {
    std::vector<Setting> settings{makeSetting(base, {})};
    for (const Knob& knob : tradeoffKnobs(base, depth)) {
        if (!matters(knob.needs, use)) {
            unused.push_back(knob.option);
            continue;
        }
        for (const nlohmann::json& value : knob.values)
            settings.push_back(makeSetting(base, {{knob.option, value}}));
    }
    return settings;
}

std::vector<Setting> combinedSettings(const Options& base, const std::vector<KnobChange>& best) {
    std::vector<Setting> settings;
    for (std::size_t i = 0; i < best.size(); ++i)
        for (std::size_t j = i + 1; j < best.size(); ++j)
            settings.push_back(makeSetting(base, {best[i], best[j]}));
    if (best.size() > 3)
        for (const KnobChange& left : best) {
            std::vector<KnobChange> others = best;
            std::erase_if(others, [&](const KnobChange& change) { return change.option == left.option; });
            settings.push_back(makeSetting(base, std::move(others)));
        }
    if (best.size() > 2)
        settings.push_back(makeSetting(base, best));
    return settings;
}

} // namespace cmpg
