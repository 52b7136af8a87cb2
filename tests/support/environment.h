// The process' environment.
#pragma once

#include <cstdlib>
#include <string>

namespace cmpg::test {

// Sets a variable of the environment, or removes it, for a scope.
class Environment {
  public:
    Environment(const char* name, const char* value) : name_(name) {
        if (const char* old = std::getenv(name))
            old_ = old, wasSet_ = true;
        value ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Environment() { wasSet_ ? setenv(name_, old_.c_str(), 1) : unsetenv(name_); }

  private:
    const char* name_;
    std::string old_;
    bool wasSet_ = false;
};

} // namespace cmpg::test
