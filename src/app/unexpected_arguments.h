// What somebody meant by an argument that no option takes.
#pragma once

#include "base/error.h"

namespace CLI {
class App;
}

namespace cmpg {

// Of a parser that found arguments which it has no place for: names the first, and the option or command that was likely meant.
Error unexpectedArgument(const CLI::App& app);

} // namespace cmpg
