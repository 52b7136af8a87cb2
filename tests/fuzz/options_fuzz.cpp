// The command line, an argument a line, and after an empty line the file that --config run.json stands for. Parsed and checked, not run.
#include "app/parse_options.h"
#include "lab/compare_methods.h"
#include "optimize/recovery_config.h"
#include "session/library_options.h"
#include "session/options.h"
#include "fuzz.h"

#include <nlohmann/json.hpp>
#include <vector>

using namespace cmpg;

namespace {

constexpr const char* kConfigName = "run.json";

std::vector<std::string> linesOf(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        lines.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    return lines;
}

Options parse(const std::vector<std::string>& lines, const std::string& config) {
    std::vector<std::string> arguments = {"cmpg-vk"};
    for (std::string line : lines) {
        if (const std::size_t at = line.find(kConfigName); at != std::string::npos)
            line.replace(at, std::string(kConfigName).size(), config);
        arguments.push_back(line.c_str()); // up to a zero byte, as a shell passes it
    }
    std::vector<const char*> pointers;
    for (const std::string& argument : arguments)
        pointers.push_back(argument.c_str());
    return parseOptions(int(pointers.size()), pointers.data());
}

// What commands make of options before they look at files.
void use(const Options& options) {
    // As run.json is written: text that is no UTF-8 is replaced, and what is read and written again is what was written.
    const std::string written = toConfig(options).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    Options again;
    applyConfig(nlohmann::json::parse(written), again);
    fuzz::require(toConfig(again) == nlohmann::ordered_json::parse(written), "a run reads the configuration it wrote");
    for (const std::uint32_t number : {options.effectiveSpp(), options.effectiveSppGradient(), options.effectiveTrainSpp(), options.effectiveDepth(8)})
        fuzz::require(number > 0, "numbers of samples and segments are positive");
    configOf(recoveryOptions(options, 0));
    checkpointInterval(options);
    parseMethods(options.methods, options);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::MemoryFile file;
    const std::string text(data, data + size);
    const std::size_t end = std::min(text.find("\n\n"), text.size());
    const std::string config = text.substr(std::min(end + 2, text.size()));
    const std::string& path = file.holding({reinterpret_cast<const std::uint8_t*>(config.data()), config.size()});
    fuzz::accepts({ErrorKind::Usage, ErrorKind::Input}, [&] {
        try {
            use(parse(linesOf(text.substr(0, end)), path));
        } catch (const HelpRequested& help) {
            fuzz::require(!help.text.empty(), "help says something");
        }
    });
    return 0;
}
