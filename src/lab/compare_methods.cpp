// The methods a comparison sets side by side: names of what draws directions.
#include "lab/compare_methods.h"

#include "base/error.h"

#include <algorithm>
#include <sstream>

namespace cmpg {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);)
        parts.push_back(part);
    if (text.empty() || text.back() == separator)
        parts.emplace_back();
    return parts;
}

bool applyName(const std::string& name, Options& options) {
    const bool defaults = name == "ours" || name == "auto";
    options.sampling = defaults ? Sampling::Auto : Sampling::Bsdf;
    options.pixelSampling = defaults ? PixelSampling::Adjoint : PixelSampling::Uniform;
    options.roulette = defaults;
    options.positivize = false;
    if (defaults || name == "plain")
        return true;
    for (const auto& kind : kSamplings)
        if (name == kind.name) {
            options.sampling = kind.value;
            return true;
        }
    return false;
}

bool applyPart(const std::string& part, Options& options) {
    const bool on = part.rfind("no", 0) != 0;
    const std::string what = on ? part : part.substr(2);
    if (what == "pixels")
        options.pixelSampling = on ? PixelSampling::Adjoint : PixelSampling::Uniform;
    else if (what == "roulette")
        options.roulette = on;
    else if (what == "positivize")
        options.positivize = on;
    else if (what == "nee")
        options.noLightSampling = !on;
    else if (part == "sobol")
        options.sampler = Sampler::Sobol;
    else if (part == "independent")
        options.sampler = Sampler::Independent;
    else
        return false;
    return true;
}

} // namespace

std::vector<CompareMethod> parseMethods(const std::string& list, const Options& base) {
    std::vector<CompareMethod> methods;
    for (const std::string& text : split(list, ',')) {
        const std::vector<std::string> parts = split(text, '+');
        CompareMethod method{text, base};
        if (!applyName(parts.front(), method.options))
            throw Error(ErrorKind::Usage, "--methods: there is no method '" + parts.front() + "'", "",
                        "methods are plain, bsdf, primal, differential, uniform, conditional, auto and ours");
        for (std::size_t i = 1; i < parts.size(); ++i)
            if (!applyPart(parts[i], method.options))
                throw Error(ErrorKind::Usage, "--methods: '" + text + "' has an unknown part '" + parts[i] + "'", "",
                            "parts are pixels, roulette, positivize, nee, each also with 'no' before it, sobol and independent");
        if (std::any_of(methods.begin(), methods.end(), [&](const CompareMethod& m) { return m.name == text; }))
            throw Error(ErrorKind::Usage, "--methods names '" + text + "' twice");
        methods.push_back(std::move(method));
    }
    return methods;
}

std::string CompareMethod::describe() const {
    std::string text;
    switch (options.sampling) {
    case Sampling::Bsdf:
        text = "no guide";
        break;
    case Sampling::Primal:
        text = "guided by light";
        break;
    case Sampling::Differential:
        text = "guided by derivatives of light";
        break;
    case Sampling::Uniform:
        text = "guided by both, half and half";
        break;
    case Sampling::Conditional:
        text = "guided by both, weighted by the path so far";
        break;
    case Sampling::Auto:
        text = "guided as training finds best";
        break;
    }
    text += options.pixelSampling != PixelSampling::Uniform ? "; more samples where the adjoint is large" : "; the same samples in all pixels";
    if (options.roulette)
        text += "; roulette and splitting where they pay";
    if (options.positivize)
        text += "; positivized";
    if (options.noLightSampling)
        text += "; no light sampling";
    if (options.sampler == Sampler::Independent)
        text += "; independent random numbers";
    return text;
}

} // namespace cmpg
