// All options of the command line, with their help.
#pragma once

namespace CLI {
class App;
}

namespace cmpg {

struct Options;

// Declares them to the parser, which fills `options`.
void declareOptions(CLI::App& app, Options& options);

} // namespace cmpg
