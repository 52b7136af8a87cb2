// The table that gradient --check prints.
#pragma once

#include <cmpg/check.h>

#include <string>

namespace cmpg {

// For people: the means of the channels and the block that differs most. `direction`: as on the command line.
std::string checkTable(const CheckResult& result, const std::string& parameter, const std::string& direction);

} // namespace cmpg
