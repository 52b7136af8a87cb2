// Numbers as plots and tables show them.
#pragma once

#include <cstdio>
#include <string>

namespace cmpg {

inline std::string threeDigits(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

} // namespace cmpg
