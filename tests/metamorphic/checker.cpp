#include "checker.h"

#include <numeric>

namespace cmpg::test {
namespace {

// A first look with few samples. What exceeds this score is looked at again with many more, and other random numbers; that look decides.
constexpr double kSuspicious = 4;
constexpr Passes kSecondLook{64, 8, 1000};
constexpr std::uint64_t kOtherSeed = 100000; // of estimates that shall be independent
// Of a gradient against a derivative image made with the same random numbers: both are sums in single precision.
constexpr double kSymmetry = 1e-4;

void add(std::vector<Image>& to, const std::vector<Image>& images, double weight) {
    if (to.empty())
        for (const Image& i : images)
            to.emplace_back(i.width, i.height, i.channels);
    for (std::size_t pass = 0; pass < images.size(); ++pass)
        for (std::size_t i = 0; i < images[pass].values.size(); ++i)
            to[pass].values[i] += float(weight * double(images[pass].values[i]));
}

double along(const std::vector<double>& gradient, const std::vector<float>& direction) {
    return std::inner_product(gradient.begin(), gradient.end(), direction.begin(), 0.0);
}

} // namespace

Directions Checker::directions(const Scene& scene) const {
    generated::Random random(seed_ + 77);
    const std::vector<bool> possible = differentiated(scene);
    const bool all = random.uniform() < 0.3f; // a lobe that a surface lacks is there where its derivative is asked for
    Directions d(scene.parameters.size());
    std::size_t last = 0;
    for (std::size_t p = 0; p < d.size(); ++p) {
        if (possible[p])
            last = p;
        const bool wanted = possible[p] && (all || random.uniform() < 0.3f);
        for (std::size_t i = 0; wanted && i < scene.parameters[p].entries(); ++i)
            d[p].push_back(random.between(-1, 1));
    }
    if (std::all_of(d.begin(), d.end(), [](const auto& v) { return v.empty(); }))
        d[last].assign(scene.parameters[last].entries(), 1);
    return d;
}

std::string Checker::repeat(const std::string& relation) const {
    return name_ + ", " + relation + "\n  repeat with CMPG_METAMORPHIC_SCENE='" + name_ + "' CMPG_METAMORPHIC_RELATION='" + relation +
           "' test_metamorphic --gtest_filter=Metamorphic.OneScene\n  ";
}

void Checker::begin(const std::string& name, std::uint32_t seed, Scene scene) {
    name_ = name;
    seed_ = seed;
    scene_ = std::move(scene);
    for (Parameter& p : scene_.parameters)
        p.materialise();
    directions_ = directions(scene_);
    own_ = run(scene_, {}, directions_, firstLook_);
    EXPECT_EQ(own_.trouble, "") << name_;
    expectSymmetry("as it is", scene_, directions_, own_);
    expectEmissionIsLinear(own_);
}

// <a, J v> = <J^T a, v>
void Checker::expectSymmetry(const std::string& what, const Scene& scene, const Directions& directions, const Outputs& outputs) {
    const Image adjoint = adjointImage();
    for (std::size_t pass = 0; pass < outputs.forward.size(); ++pass) {
        double forward = 0, reverse = 0, size = 0;
        for (std::size_t i = 0; i < adjoint.values.size(); ++i) {
            forward += double(adjoint.values[i]) * outputs.forward[pass].values[i];
            size += double(adjoint.values[i]) * std::abs(outputs.forward[pass].values[i]);
        }
        for (std::size_t p = 0; p < scene.parameters.size(); ++p)
            for (std::size_t i = 0; i < outputs.reverse[pass][p].size(); ++i) {
                const double term = outputs.reverse[pass][p][i] * double(directions[p][i]);
                reverse += term;
                size += std::abs(term);
            }
        ++comparisons_;
        EXPECT_LE(std::abs(forward - reverse), kSymmetry * size) << repeat(what) << "forward " << forward << ", reverse " << reverse << ", pass " << pass;
    }
}

// Light from emitters alone is their derivative along themselves.
void Checker::expectEmissionIsLinear(const Outputs& outputs) {
    if (!scene_.lights.empty())
        return;
    const std::vector<bool> possible = differentiated(scene_);
    Directions self(scene_.parameters.size());
    for (std::size_t p = 0; p < self.size(); ++p)
        if (possible[p] && (scene_.parameters[p].kind == SlotKind::Emission || scene_.parameters[p].kind == SlotKind::Radiance))
            self[p] = scene_.parameters[p].values;
        else if (!directions_[p].empty())
            self[p].assign(directions_[p].size(), 0);
    Passes one = firstLook_;
    one.count = 1;
    const Outputs derivative = run(scene_, {}, self, one);
    // Where a material is a metal, or none, directions are drawn for its derivative too: a few paths differ.
    for (const Comparison& c : compareImages("image", {outputs.image[0]}, derivative.forward, 1e-5)) {
        ++comparisons_;
        EXPECT_LE(c.score(), allowed_) << repeat("as it is") << "the derivative along the emission is not the image, " << c.what << ": "
                                       << c.difference / c.size * 200 << " % apart";
    }
}

Checker::Sum Checker::sum(const Relation& relation, const std::vector<Term>& terms, const Passes& passes) {
    Sum s;
    s.reverse.resize(passes.count);
    for (auto& pass : s.reverse)
        for (const auto& d : directions_)
            pass.emplace_back(d.size(), 0.0);
    Passes own = passes;
    for (const Term& t : terms) {
        const Directions moved = pushed(directions_, t.sources, t.scene);
        const Outputs o = run(t.scene, t.setup, moved, own);
        EXPECT_EQ(o.trouble, "") << repeat(relation.name);
        add(s.image, o.image, t.weight);
        add(s.forward, o.forward, t.weight);
        for (std::uint32_t i = 0; i < own.count; ++i)
            pull(o.reverse[i], t.sources, t.weight, s.reverse[i]);
        if (!t.setup.roulette)
            expectSymmetry(relation.name, t.scene, moved, o);
        own.firstSeed += kOtherSeed;
    }
    return s;
}

std::vector<Comparison> Checker::compare(const Relation& relation, const Sum& a, const Sum& b) const {
    std::vector<Comparison> all = compareImages("image", a.image, b.image, relation.tolerance);
    const std::vector<Comparison> forward = compareImages("forward", a.forward, b.forward, relation.tolerance);
    all.insert(all.end(), forward.begin(), forward.end());
    return all;
}

void Checker::expectBits(const std::string& what, const Sum& a, const Sum& b) {
    for (std::size_t pass = 0; pass < a.image.size(); ++pass) {
        comparisons_ += 3;
        EXPECT_TRUE(a.image[pass].values == b.image[pass].values) << repeat(what) << "image";
        EXPECT_TRUE(a.forward[pass].values == b.forward[pass].values) << repeat(what) << "forward";
        for (std::size_t p = 0; p < a.reverse[pass].size(); ++p)
            for (std::size_t i = 0; i < a.reverse[pass][p].size(); ++i)
                if (std::abs(a.reverse[pass][p][i] - b.reverse[pass][p][i]) > 1e-6 * std::abs(a.reverse[pass][p][i]) + 1e-9)
                    ADD_FAILURE() << repeat(what) << "reverse, " << scene_.parameters[p].name << "[" << i << "]: " << a.reverse[pass][p][i] << " and "
                                  << b.reverse[pass][p][i];
    }
}

void Checker::pool(const std::string& relation, const Sum& a, const Sum& b) {
    const auto take = [&](const std::string& output, double x, double y, double size) {
        if (size > 0) {
            Comparison& c = pooled_[{relation, output}];
            c.what = output;
            c.add(x / size, y / size);
        }
    };
    const auto images = [&](const std::string& output, const std::vector<Image>& x, const std::vector<Image>& y) {
        double first = 0, second = 0, size = 0;
        for (std::size_t pass = 0; pass < x.size(); ++pass)
            for (std::size_t i = 0; i < x[pass].values.size(); ++i) {
                first += x[pass].values[i];
                second += y[pass].values[i];
                size += std::abs(x[pass].values[i]) + std::abs(y[pass].values[i]);
            }
        take(output, first, second, size);
    };
    images("image", a.image, b.image);
    images("forward", a.forward, b.forward);
    std::vector<double> first(kMaterialSlots + 1, 0), second = first, size = first;
    for (std::size_t pass = 0; pass < a.reverse.size(); ++pass)
        for (std::size_t p = 0; p < a.reverse[pass].size(); ++p) {
            const std::size_t kind = std::size_t(scene_.parameters[p].kind);
            const double x = along(a.reverse[pass][p], directions_[p]), y = along(b.reverse[pass][p], directions_[p]);
            first[kind] += x;
            second[kind] += y;
            size[kind] += std::abs(x) + std::abs(y);
        }
    for (std::size_t kind = 0; kind < first.size(); ++kind)
        take(std::string("reverse, ") + slotName(SlotKind(kind)), first[kind], second[kind], size[kind]);
}

void Checker::check(const Relation& relation) {
    ++scenes_[relation.name];
    const std::size_t number = std::size_t(&relation - relations().data());
    generated::Random random(seed_ * 101 + std::uint32_t(number));
    const std::vector<Term> terms = relation.terms(scene_, random);
    const bool independent = relation.agreement == Agreement::Expected;
    const auto others = [&](Passes passes) {
        if (independent)
            passes.firstSeed += kOtherSeed;
        return sum(relation, terms, passes);
    };
    const Sum a{own_.image, own_.forward, own_.reverse}, b = others(firstLook_);
    if (relation.agreement == Agreement::Bits) {
        expectBits(relation.name, a, b);
        return;
    }
    pool(relation.name, a, b);
    std::vector<Comparison> found = compare(relation, a, b);
    comparisons_ += found.size();
    if (std::none_of(found.begin(), found.end(), [](const Comparison& c) { return c.score() > kSuspicious; }))
        return;
    const Outputs again = run(scene_, {}, directions_, kSecondLook);
    found = compare(relation, {again.image, again.forward, again.reverse}, others(kSecondLook));
    for (const Comparison& c : found)
        if (c.score() > allowed_)
            ADD_FAILURE() << repeat(relation.name) << c.what << ": " << c.difference / c.size * 200 << " % apart, score " << c.score() << " of " << allowed_
                          << " allowed, " << c.terms << " pixels";
}

void Checker::finish() {
    for (const auto& [which, c] : pooled_) {
        ++comparisons_;
        Comparison sum = c;
        sum.tolerance = 1e-4;
        for (const Relation& r : relations())
            if (r.name == which.first)
                sum.tolerance = std::max(sum.tolerance, r.tolerance);
        EXPECT_LE(sum.score(), allowed_) << which.first << ", " << which.second << ", " << c.terms << " scenes together: " << c.difference / c.size * 200 << " % apart";
    }
}

} // namespace cmpg::test
