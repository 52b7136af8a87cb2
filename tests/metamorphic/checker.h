// Tries relations on scenes, and keeps account of what differs.
#pragma once

#include "acceptance.h"
#include "relations.h"

#include <map>

namespace cmpg::test {

class Checker {
  public:
    // `comparisons`: about how many there will be, which the allowed scores depend on. `passes` of the first look.
    explicit Checker(double comparisons, std::uint32_t passes = 4) : allowed_(allowedScore(comparisons)), firstLook_{passes, 4, 1} {}

    // A scene and what it is called in failures; its own outputs are made once for all relations that follow.
    void begin(const std::string& name, std::uint32_t seed, Scene scene);
    void check(const Relation& relation);
    // Over all scenes of a relation together: differences that are too small to show in one.
    void finish();

    std::size_t comparisons() const { return comparisons_; }
    const std::map<std::string, std::size_t>& scenes() const { return scenes_; } // by relation

  private:
    struct Sum { // of a relation's terms
        std::vector<Image> image, forward;
        std::vector<std::vector<std::vector<double>>> reverse;
    };

    Directions directions(const Scene& scene) const;
    Sum sum(const Relation& relation, const std::vector<Term>& terms, const Passes& passes);
    std::vector<Comparison> compare(const Relation& relation, const Sum& a, const Sum& b) const;
    void expectSymmetry(const std::string& what, const Scene& scene, const Directions& along, const Outputs& outputs);
    void expectBits(const std::string& what, const Sum& a, const Sum& b);
    void expectEmissionIsLinear(const Outputs& outputs);
    void pool(const std::string& relation, const Sum& a, const Sum& b);
    std::string repeat(const std::string& relation) const;

    double allowed_;
    Passes firstLook_;
    std::string name_;
    std::uint32_t seed_ = 0;
    Scene scene_;
    Directions directions_;
    Outputs own_;
    std::size_t comparisons_ = 0;
    std::map<std::string, std::size_t> scenes_;
    std::map<std::pair<std::string, std::string>, Comparison> pooled_; // by relation and output
};

} // namespace cmpg::test
