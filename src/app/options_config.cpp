// Options as run.json: writing and reading back.
#include "app/options.h"

#include "base/error.h"
#include "scene/file_io.h"

#include <filesystem>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

// Calls v(key, field) for every option that bears on a result; keys are the names on the command line. Enumerations come with
// their names. Each command adds its own.
template <class O, class V> void visitCommon(O& o, V&& v) {
    v("quality", o.quality, kQualities);
    v("spp", o.spp);
    v("spp-gradient", o.sppGradient);
    v("seed", o.seed);
    v("sampler", o.sampler, kSamplers);
    v("sampling", o.sampling, kSamplings);
    v("no-nee", o.noLightSampling);
    v("pixel-sampling", o.pixelSampling, kPixelSamplings);
    v("positivize", o.positivize);
    v("roulette", o.roulette, kRoulettes);
    v("train", o.train);
    v("train-spp", o.trainSpp);
    v("load-guide", o.loadGuide);
    v("guide-memory", o.guideMemory);
    v("guide-share", o.guideShare);
    v("cell-records", o.cellRecords);
    v("direction-share", o.directionShare);
    v("forgetting", o.forgetting);
    v("roulette-effort", o.rouletteEffort);
    v("width", o.width);
    v("height", o.height);
    v("camera", o.camera);
    v("max-depth", o.maxDepth);
    v("set", o.set);
    v("environment", o.environment);
    v("environment-rotation", o.environmentRotation);
    v("define", o.define);
    v("device", o.device);
    v("memory", o.memory);
}

template <class O, class V> void visitBudget(O& o, V&& v) {
    v("error-target", o.errorTarget);
    v("time-budget", o.timeBudget);
    v("batches", o.batches);
}

template <class O, class V> void visitTarget(O& o, V&& v) {
    v("param", o.param);
    v("target", o.target);
    v("loss", o.loss, kLosses);
    v("mask", o.mask);
    v("target-exposure", o.targetExposure);
}

template <class O, class V> void visitDifferentiation(O& o, V&& v) {
    v("direction", o.direction);
    v("adjoint", o.adjoint);
}

template <class O, class V> void visitGradient(O& o, V&& v) {
    visitDifferentiation(o, v);
    v("check", o.check);
}

template <class O, class V> void visitOptimize(O& o, V&& v) {
    v("steps", o.steps);
    v("optimizer", o.optimizer, kOptimizers);
    v("rate", o.rate);
    v("schedule", o.schedule, kSchedules);
    v("final-rate", o.finalRate);
    v("total-variation", o.totalVariation);
    v("prior", o.prior);
    v("spp-difference", o.sppDifference);
    v("views-per-step", o.viewsPerStep);
    v("warm-up", o.warmUp);
    v("freeze", o.freeze);
    v("stop-after", o.stopAfter);
}

template <class O, class V> void visitGuide(O& o, V&& v) {
    v("validate", o.validateGuide);
    v("csv", o.csv);
    v("cell", o.cell);
    v("weights", o.weights);
}

template <class O, class V> void visitCompare(O& o, V&& v) {
    v("methods", o.methods);
    v("mode", o.mode);
    v("time", o.time);
    v("seeds", o.seeds);
    v("reference", o.reference);
    v("reference-time", o.referenceTime);
    v("adjoint-spp", o.adjointSpp);
    visitDifferentiation(o, v);
    visitOptimize(o, v);
}

template <class O, class V> void visitTradeoff(O& o, V&& v) {
    v("time", o.time);
    v("seeds", o.seeds);
    visitDifferentiation(o, v);
}

template <class O, class V> void visitView(O& o, V&& v) {
    v("signed", o.isSigned);
    v("exposure", o.exposure);
    v("scale", o.scale);
    v("layer", o.layer);
}

[[noreturn]] void refuse(const std::string& what, const std::string& remedy = "") {
    throw Error(ErrorKind::Usage, what, "", remedy);
}

template <class T> struct IsOptional : std::false_type {};
template <class T> struct IsOptional<std::optional<T>> : std::true_type { using Value = T; };

// Shortest decimal that reads back as the same float: 0.1f is 0.1 in the file.
double shortDecimal(float value) {
    char text[32];
    for (int digits = 6; digits <= 9; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, double(value));
        if (std::strtof(text, nullptr) == value)
            break;
    }
    return std::strtod(text, nullptr);
}

struct Writer {
    nlohmann::ordered_json& json;

    template <class T> void operator()(const char* key, const T& field) {
        if constexpr (IsOptional<T>::value) {
            if (field)
                (*this)(key, *field);
        } else if constexpr (std::is_same_v<T, float>) {
            json[key] = shortDecimal(field);
        } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::vector<std::string>>) {
            if (!field.empty())
                json[key] = field; // empty: not given
        } else {
            json[key] = field;
        }
    }
    template <class T, class E, std::size_t N> void operator()(const char* key, const T& field, const EnumName<E> (&names)[N]) {
        if constexpr (IsOptional<T>::value) {
            if (field)
                (*this)(key, *field, names);
        } else {
            for (const auto& n : names)
                if (n.value == field)
                    json[key] = n.name;
        }
    }
};

// Takes over the one value whose key it is given.
struct Reader {
    const std::string& key;
    const nlohmann::json& value;
    bool found = false;

    template <class T> void operator()(const char* name, T& field) {
        if (key != name)
            return;
        found = true;
        if constexpr (IsOptional<T>::value) {
            field = read<typename IsOptional<T>::Value>();
        } else {
            field = read<T>();
        }
    }
    template <class T, class E, std::size_t N> void operator()(const char* name, T& field, const EnumName<E> (&names)[N]) {
        if (key != name)
            return;
        found = true;
        const std::string text = read<std::string>();
        for (const auto& n : names) {
            if (text != n.name)
                continue;
            field = n.value;
            return;
        }
        refuse("the configuration has an unknown value for '" + key + "': '" + text + "'");
    }

  private:
    // The library converts between kinds of numbers in silence; a negative or fractional count must not pass.
    template <class T> T read() const {
        bool fits = false;
        if constexpr (std::is_same_v<T, bool>) {
            fits = value.is_boolean();
        } else if constexpr (std::is_unsigned_v<T>) {
            fits = value.is_number_unsigned() && value.get<std::uint64_t>() <= std::numeric_limits<T>::max();
        } else if constexpr (std::is_floating_point_v<T>) {
            fits = value.is_number();
        } else if constexpr (std::is_same_v<T, std::string>) {
            fits = value.is_string();
        } else {
            fits = value.is_array();
            for (const auto& element : value)
                fits = fits && element.is_string();
        }
        if (!fits)
            refuse("the configuration has a value of the wrong kind for '" + key + "': " + value.dump());
        return value.get<T>();
    }
};

std::string absolutePath(const std::string& path) {
    return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

// The file part of "NAME=FILE" made absolute, if a file is what it is.
std::string absoluteAssignment(const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::string file = equals == std::string::npos ? text : text.substr(equals + 1);
    if (!fileExists(file))
        return text;
    return (equals == std::string::npos ? "" : text.substr(0, equals + 1)) + absolutePath(file);
}

} // namespace

nlohmann::ordered_json toConfig(const Options& options) {
    Options o = options;
    o.spp = o.effectiveSpp();
    if (o.command != Command::Compare || o.mode.find(',') == std::string::npos) // the default differs between the modes
        o.sppGradient = o.effectiveSppGradient();
    if (!o.pixelSampling)
        o.pixelSampling = PixelSampling::Adjoint;
    o.train = o.effectiveTrain();
    if (o.command == Command::Render || o.command == Command::Gradient) {
        if (*o.train > 0)
            o.trainSpp = o.effectiveTrainSpp();
        if (const std::uint32_t batches = o.effectiveBatches())
            o.batches = batches;
    }
    o.mask = absolutePath(o.mask);
    o.environment = absolutePath(o.environment);
    o.adjoint = absolutePath(o.adjoint);
    o.loadGuide = absolutePath(o.loadGuide);
    if (o.reference != "auto")
        o.reference = absolutePath(o.reference);
    if (o.direction != "one" && o.direction != "self")
        o.direction = absolutePath(o.direction);
    for (std::string& s : o.set)
        s = absoluteAssignment(s);
    for (std::string& t : o.target)
        t = absoluteAssignment(t);

    nlohmann::ordered_json json;
    json["command"] = commandName(o.command);
    if (!o.input.empty())
        json["input"] = absolutePath(o.input);
    Writer writer{json};
    if (o.command == Command::View) {
        visitView(o, writer);
        return json;
    }
    if (o.command == Command::Guide) {
        visitGuide(o, writer);
        return json;
    }
    visitCommon(o, writer);
    if (o.command == Command::Render || o.command == Command::Gradient || o.command == Command::Optimize)
        visitBudget(o, writer);
    if (o.command == Command::Gradient || o.command == Command::Optimize || o.command == Command::Compare || o.command == Command::Tradeoff)
        visitTarget(o, writer);
    if (o.command == Command::Gradient)
        visitGradient(o, writer);
    if (o.command == Command::Optimize) {
        visitOptimize(o, writer);
        writer("checkpoint-every", o.checkpointEvery);
    }
    if (o.command == Command::Compare)
        visitCompare(o, writer);
    if (o.command == Command::Tradeoff)
        visitTradeoff(o, writer);
    return json;
}

void applyConfig(const nlohmann::json& config, Options& options) {
    if (!config.is_object())
        refuse("the configuration is not a JSON object");
    for (const auto& [key, value] : config.items()) {
        if (key == "made-with")
            continue; // program, device and driver: for the reader
        Reader reader{key, value};
        reader("command", options.command, kCommands);
        reader("input", options.input);
        visitCommon(options, reader);
        visitBudget(options, reader);
        visitTarget(options, reader);
        visitGradient(options, reader);
        visitOptimize(options, reader);
        reader("checkpoint-every", options.checkpointEvery);
        visitCompare(options, reader);
        visitView(options, reader);
        visitGuide(options, reader);
        if (!reader.found)
            refuse("the configuration has an unknown key '" + key + "'", "keys are the names of options without the dashes");
    }
}

} // namespace cmpg
