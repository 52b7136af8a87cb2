// The one exception of the library: what went wrong, the likely cause and the remedy.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cmpg {

enum class ErrorKind {
    Usage,     // an argument, a name or a value that makes no sense: a mistake of the caller's
    Input,     // a scene, an image or another file that is missing or malformed
    Device,    // no Vulkan device, or one that lacks a required feature, is lost, has too little memory or computes wrong results
    Numerical, // values so large or small that floats overflow
    Output,    // a result could not be written
};

class Error : public std::runtime_error {
  public:
    // `what`: one sentence that names the file, parameter or device. The others may be empty.
    Error(ErrorKind errorKind, const std::string& what, std::string likelyCause = {}, std::string howToFix = {}, std::vector<std::string> about = {})
        : std::runtime_error(what), kind(errorKind), cause(std::move(likelyCause)), remedy(std::move(howToFix)), options(std::move(about)) {}

    ErrorKind kind;
    std::string cause, remedy;
    // What the remedy would have changed, by the names of the command line without dashes: "max-depth" is --max-depth there, max_depth in Python
    // and maxDepth in C++. "inspect" is the command that lists what a scene holds, here Scene::parameters() and cameras().
    std::vector<std::string> options;
};

} // namespace cmpg
