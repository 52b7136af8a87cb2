// The table of options as the parser wants it.
#pragma once

namespace CLI {
class App;
}

namespace cmpg {

struct Options;

// Declares all options and commands to the parser, which fills `options`.
void declareOptions(CLI::App& app, Options& options);

// Declares what is asked without a scene: --help, and these two.
void declareQuestions(CLI::App& app, bool& listDevices, bool& version);

} // namespace cmpg
