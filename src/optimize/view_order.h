// Which views a step sees, where it does not see all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cmpg {

// A step sees the views after those of the step before, from random orders of all views, one order after the other. So every view is equally likely, and each
// is seen once before any is seen again. No step sees views of two orders: it could see one twice. The steps of an order see as many views each, or one less.
class ViewOrder {
  public:
    // `perStep`: so many a step at most, all of them where it is not less than `views`; 0: one, and about one more after every order, at last all or 16. So no
    // step takes much more than 1 / `views` of the time of all before it.
    ViewOrder(std::uint64_t seed, std::size_t views, std::uint32_t perStep) : seed_(seed), views_(views), perStep_(perStep) {}

    // All views in their own order where a step sees all.
    std::vector<std::size_t> viewsOf(std::uint32_t step) const;
    bool seesAll(std::uint32_t step) const { return at(step).count >= views_; }
    std::uint32_t stepsBeforeAll() const; // the first step that sees all views; the largest number where none does
    std::uint64_t seenBefore(std::uint32_t step) const { return at(step).seen; } // views, each as often as steps saw it
    // By the time of a step, how many orders have been seen whole that began at `start` or later.
    std::uint32_t wholeOrders(std::uint32_t start, std::uint32_t step) const;

  private:
    struct Place {
        std::uint64_t seen = 0;  // views, by the steps before
        std::uint64_t count = 1; // of views of this step
    };
    Place at(std::uint32_t step) const;

    std::uint64_t seed_;
    std::size_t views_;
    std::uint32_t perStep_;
};

} // namespace cmpg
