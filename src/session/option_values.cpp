// Values with units, as people write them: 1 %, 60s, 5min.
#include "session/option_values.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <utility>

namespace cmpg {
namespace {

// A finite number and a unit, with or without a space between.
std::optional<double> parse(const std::string& text, std::initializer_list<std::pair<const char*, double>> units) {
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || !std::isfinite(number) || text.find_first_of("xX") != std::string::npos) // hexadecimal
        return {};
    while (*end == ' ')
        ++end;
    for (const auto& [name, factor] : units)
        if (std::string(end) == name)
            return number * factor;
    return {};
}

} // namespace

std::optional<double> parseFraction(const std::string& text) { return parse(text, {{"", 1}, {"%", 0.01}}); }

std::optional<double> parseSeconds(const std::string& text) {
    return parse(text, {{"", 1}, {"s", 1}, {"m", 60}, {"min", 60}, {"h", 3600}});
}

std::string exactDecimal(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

} // namespace cmpg
