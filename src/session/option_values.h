// Values with units, as people write them: 1 %, 60s, 5min.
#pragma once

#include <optional>
#include <string>

namespace cmpg {

std::optional<double> parseFraction(const std::string& text); // "1%" or "0.01"
std::optional<double> parseSeconds(const std::string& text);  // "90", "90s", "1.5min", "1h"

std::string exactDecimal(double value); // reads back as the same

} // namespace cmpg
