// Options as run.json: writing and reading back.
#include "session/options.h"

#include "base/error.h"
#include "session/option_table.h"
#include "session/parameter_values.h"
#include "session/refuse.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

namespace cmpg {
namespace {

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

template <class T> constexpr bool kIsText = std::is_same_v<T, std::string> || std::is_same_v<T, std::vector<std::string>>;

// Of texts that are empty where they are not given. Others may be given as empty, which is not their default.
const std::set<std::string>& keysEmptyByDefault() {
    static const std::set<std::string> keys = [] {
        std::set<std::string> found;
        const Options options;
        for (int group = 0; group <= int(kLastGroup); ++group)
            visitGroup(OptionGroup(group), options, [&]<class T>(const OptionSpec& option, const T& field, const auto&...) {
                if constexpr (kIsText<T>)
                    if (field.empty())
                        found.insert(option.key);
            });
        return found;
    }();
    return keys;
}

struct Writer {
    nlohmann::ordered_json& json;

    template <class T, class... Meaning> void operator()(const OptionSpec& option, const T& field, const Meaning&... meaning) {
        if (option.role != OptionRole::Output)
            write(option.key, field, meaning...);
    }

  private:
    template <class T> void write(const char* key, const T& field) {
        if constexpr (IsOptional<T>::value) {
            if (field)
                write(key, *field);
        } else if constexpr (std::is_same_v<T, float>) {
            json[key] = shortDecimal(field);
        } else if constexpr (kIsText<T>) {
            if (!field.empty() || !keysEmptyByDefault().contains(key))
                json[key] = field;
        } else {
            json[key] = field;
        }
    }
    template <class T> void write(const char* key, const T& field, Unit) { write(key, field); }
    template <class T, class E, std::size_t N> void write(const char* key, const T& field, const EnumName<E> (&names)[N]) {
        if constexpr (IsOptional<T>::value) {
            if (field)
                write(key, *field, names);
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

    template <class T> void operator()(const OptionSpec& option, T& field) {
        if (!takes(option))
            return;
        if constexpr (IsOptional<T>::value) {
            field = read<typename IsOptional<T>::Value>();
        } else {
            field = read<T>();
        }
    }
    template <class T> void operator()(const OptionSpec& option, T& field, Unit) { (*this)(option, field); }
    template <class T, class E, std::size_t N> void operator()(const OptionSpec& option, T& field, const EnumName<E> (&names)[N]) {
        if (!takes(option))
            return;
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
    bool takes(const OptionSpec& option) {
        const bool mine = key == option.key && option.role != OptionRole::Output;
        found |= mine;
        return mine;
    }
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

bool isFile(const std::string& text) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(text, ignored);
}

// "P=FILE" with an absolute file; "P=VALUE" as it is, even where a file has that name.
std::string absoluteSetting(const std::string& text) {
    const std::size_t equals = text.find('=');
    const std::string value = equals == std::string::npos ? "" : text.substr(equals + 1);
    return isFile(value) && !parseNumbers(value) ? text.substr(0, equals + 1) + absolutePath(value) : text;
}

// "CAMERA=FILE" or "FILE", read as cameraFileOf() does: where both may be meant the scene decides, by the text as it is.
std::string absoluteTarget(const std::string& text) {
    const std::size_t equals = text.find('=');
    const bool ofCamera = equals != std::string::npos && isFile(text.substr(equals + 1));
    if (isFile(text))
        return ofCamera ? text : absolutePath(text);
    return ofCamera ? text.substr(0, equals + 1) + absolutePath(text.substr(equals + 1)) : text;
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
    o.environment = absolutePath(o.environment);
    o.adjoint = absolutePath(o.adjoint);
    o.loadGuide = absolutePath(o.loadGuide);
    if (o.command == Command::Optimize) // which learns from the first step on then, also when it continues
        o.saveGuide = absolutePath(o.saveGuide);
    else
        o.saveGuide.clear();
    if (o.reference != "auto")
        o.reference = absolutePath(o.reference);
    if (o.direction != "one" && o.direction != "self")
        o.direction = absolutePath(o.direction);
    for (std::string& s : o.set)
        s = absoluteSetting(s);
    for (std::vector<std::string>* files : {&o.target, &o.mask})
        for (std::string& file : *files)
            file = absoluteTarget(file);

    nlohmann::ordered_json json;
    json["command"] = commandName(o.command);
    if (!o.input.empty())
        json["input"] = absolutePath(o.input);
    Writer writer{json};
    for (const OptionGroup group : recordedGroups(o.command))
        visitGroup(group, o, writer);
    return json;
}

std::set<std::string> identityKeys() {
    std::set<std::string> keys;
    const Options options;
    for (int group = 0; group <= int(kLastGroup); ++group)
        visitGroup(OptionGroup(group), options, [&](const OptionSpec& option, const auto&...) {
            if (option.role == OptionRole::Result)
                keys.insert(option.key);
        });
    return keys;
}

void applyConfig(const nlohmann::json& config, Options& options) {
    if (!config.is_object())
        refuse("the configuration is not a JSON object");
    for (const auto& [key, value] : config.items()) {
        if (key == "made-with")
            continue; // program, device and driver: for the reader
        Reader reader{key, value};
        reader({"command"}, options.command, kCommands);
        reader({"input"}, options.input);
        for (int group = 0; group <= int(kLastGroup); ++group)
            visitGroup(OptionGroup(group), options, reader);
        if (!reader.found)
            refuse("the configuration has an unknown key '" + key + "'", "keys are the names of options without the dashes");
    }
}

} // namespace cmpg
