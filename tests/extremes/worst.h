// The worst error of a quantity over a range of inputs: printed as a row of the table in docs/numerics.md, and held to its bound.
#pragma once

#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <string>

namespace cmpg::test {

class Worst {
  public:
    // `bound`: of the errors added; `what`: family, quantity and range, separated by " | "; `truth`: what it is compared with.
    Worst(std::string what, std::string truth, double bound) : what_(std::move(what)), truth_(std::move(truth)), bound_(bound) {}
    Worst(const Worst&) = delete;
    ~Worst() {
        const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
        std::printf("| %s | %s | %.1e | %.1e | %s.%s |\n", what_.c_str(), truth_.c_str(), worst_, bound_, test->test_suite_name(), test->name());
        EXPECT_GT(count_, 0u) << what_ << ": nothing was compared";
        EXPECT_LE(worst_, bound_) << what_ << "\nat " << where_;
    }

    // `where` is called for what is worse than all before: what to look at when the bound does not hold.
    template <class Where> void add(double error, Where&& where) {
        ++count_;
        if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
        if (error <= worst_) return;
        worst_ = error;
        where_ = where();
    }

    // Relative to `scale`, by default the truth; what both call nothing, up to `floor`, agrees.
    template <class Where> void compare(double value, double truth, Where&& where, double scale = 0, double floor = 1e-30) {
        const double size = std::max(std::abs(truth), scale);
        const double difference = std::abs(value - truth);
        add(difference <= floor ? 0.0 : difference / size, std::forward<Where>(where));
    }

    std::size_t count() const { return count_; }

  private:
    std::string what_, truth_, where_;
    double bound_, worst_ = 0;
    std::size_t count_ = 0;
};

// Four standard errors: what a right sampler exceeds once in 16 000 trials.
class Bias {
  public:
    Bias(std::string what, std::string truth) : worst_(std::move(what), std::move(truth) + ", in standard errors", 4) {}
    template <class Where> void add(double mean, double standardError, double truth, double rounding, Where&& where) {
        worst_.add(std::max(0.0, std::abs(mean - truth) - rounding) / std::max(standardError, 1e-300), std::forward<Where>(where));
    }

  private:
    Worst worst_;
};

} // namespace cmpg::test
