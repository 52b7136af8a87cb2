// However directions are drawn, expectations stay: gradients and images of guided passes against unguided ones. Seeds are fixed.
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

constexpr Sampling kGuidedKinds[] = {Sampling::Primal, Sampling::Differential, Sampling::Uniform, Sampling::Conditional};

// Estimates by slot: parameters of one kind are summed. The last entry is the forward derivative image against the adjoint.
using Estimates = std::vector<std::vector<double>>;
constexpr std::size_t kForwardEntry = kMaterialSlots + 1;

void addReverse(const GuidedBench& s, const std::vector<std::vector<double>>& gradient, std::vector<double>& sums) {
    for (std::size_t i = 0; i < gradient.size(); ++i)
        sums[std::size_t(s.scene.parameters[s.config.differentiable[i]].kind)] += s.along(gradient, i);
}

double forwardSum(GuidedBench& s, std::uint32_t spp, const PassKey& key) {
    const Image image = s.renderer->forward(s.view, spp, key, s.config.differentiable, s.directions, s.plan, &s.result);
    return std::inner_product(image.values.begin(), image.values.end(), s.adjoint.values.begin(), 0.0);
}

struct Budget {
    std::uint32_t seeds, spp;
};

Estimates estimate(GuidedBench& s, const Budget& budget, std::uint64_t firstSeed, const PassPlan& sampling, bool forward = false) {
    Estimates all(kForwardEntry + 1);
    for (std::uint32_t i = 0; i < budget.seeds; ++i) {
        std::vector<double> sums(kForwardEntry + 1, 0.0);
        for (const int sign : sampling.sign == 0 ? std::vector{0} : std::vector{1, -1}) { // both signs: the whole
            PassPlan half = sampling;
            half.sign = sign;
            s.plan = half;
            const PassKey key{firstSeed + i, 0, sign < 0 ? 9u : 1u};
            addReverse(s, s.gradient(budget.spp, key), sums);
            if (forward)
                sums[kForwardEntry] += forwardSum(s, budget.spp, key);
        }
        for (std::size_t k = 0; k < sums.size(); ++k)
            all[k].push_back(sums[k]);
    }
    return all;
}

class GuidedExpectation : public testing::TestWithParam<std::string> {
  protected:
    // Every way of drawing against the unguided gradients of all slots.
    void run(int edge, const Budget& budget) {
        GuidedBench s(GetParam(), {"*"}, edge);
        const Estimates truth = estimate(s, {2 * budget.seeds, budget.spp}, 1, {}, true);
        std::uint64_t seed = 1000;
        const auto compare = [&](const std::string& what, const PassPlan& sampling, bool forward = false) {
            const Estimates guided = estimate(s, budget, seed += 1000, sampling, forward);
            for (std::size_t k = 0; k < truth.size(); ++k) {
                if (k == kForwardEntry && !forward)
                    continue;
                const std::string slot = k == kForwardEntry ? "forward" : slotName(SlotKind(k));
                expectAgreement(statistics(guided[k]), statistics(truth[k]), what + ", " + slot);
            }
        };
        compare("positivized before anything is learned", {.method = {Sampling::Conditional}, .sign = 1}, true);
        const double reference = s.train(3, budget.spp);
        const SdTree trained = s.renderer->guide();
        ASSERT_GT(trained.cells().size(), 3u);
        for (const Sampling kind : kGuidedKinds)
            compare("trained, kind " + std::to_string(int(kind)), {.method = {kind}}, true);
        compare("recording", {.method = {Sampling::Conditional}, .record = true});
        compare("positivized unguided", {.sign = 1});
        compare("positivized", {.method = {Sampling::Conditional}, .sign = 1}, true);
        for (const double factor : {0.05, 1.0, 20.0}) // splits nearly everywhere, the intended amount, kills nearly everywhere
            compare("roulette at " + std::to_string(factor), {.method = {Sampling::Conditional, true}, .reference = factor * reference});
        compare("roulette unguided", {.method = {.roulette = true}, .reference = reference});
        compare("roulette positivized", {.method = {Sampling::Primal, true}, .sign = 1, .reference = reference});
        // What another scene taught, in this one's box.
        GuidedBench other(GetParam() == "box" ? "environment" : "box", {"*.baseColor"}, edge);
        other.train(3, budget.spp);
        SdTree wrong = trained;
        for (std::size_t i = 0; i < wrong.cells().size(); ++i)
            wrong.cells()[i] = other.renderer->guide().cells()[i % other.renderer->guide().cells().size()];
        s.renderer->setGuide(wrong);
        compare("another scene's guide", {.method = {Sampling::Conditional}});
        for (const Misleading how : {Misleading::Nothing, Misleading::OneBin, Misleading::BelowTheHorizon, Misleading::Poles, Misleading::DerivativesOnly,
                                     Misleading::Spike}) {
            s.renderer->setGuide(misleading(trained, how));
            compare("misleading guide " + std::to_string(int(how)), {.method = {how == Misleading::Spike ? Sampling::Uniform : Sampling::Conditional}});
        }
        for (const auto& [what, count] : s.renderer->statistics().dropped)
            EXPECT_EQ(count, 0u) << what;
        // A bias of the densities would show: what has one sign is known to a few percent. The others' sums cancel.
        for (const SlotKind k : {SlotKind::BaseColor, SlotKind::Emission, SlotKind::Radiance})
            if (const MeanError e = statistics(truth[std::size_t(k)]); e.mean != 0) {
                EXPECT_LT(e.standardError, 0.04 * e.mean) << slotName(k);
            }
    }
};

TEST_P(GuidedExpectation, AllSlots) { run(12, {12, 8}); }
TEST_P(GuidedExpectation, FullAllSlots) { run(24, {64, 32}); }

const auto nameOfScene = [](const auto& scene) { return std::string(scene.param); };
INSTANTIATE_TEST_SUITE_P(Scenes, GuidedExpectation, testing::Values("materials"), nameOfScene); // all slots, area lights and an environment
INSTANTIATE_TEST_SUITE_P(FullScenes, GuidedExpectation, testing::Values("box", "environment"), nameOfScene);

// Images are guided by light alone, whatever kind is asked for.
TEST(GuidedImage, KeepsItsMean) {
    for (const char* name : {"materials", "environment"}) {
        GuidedBench s(name, {"*.baseColor"}, 16);
        s.train(3, 8);
        std::vector<double> plain, guided;
        for (std::uint32_t i = 0; i < 24; ++i) {
            s.plan = {};
            plain.push_back(meanOf(s.renderer->render(s.view, 16, {i, 0, 0}, s.plan, &s.result)));
            s.plan = {.method = {Sampling::Conditional}};
            const Image image = s.renderer->render(s.view, 16, {100 + i, 0, 0}, s.plan, &s.result);
            guided.push_back(meanOf(image));
            s.plan = {.method = {Sampling::Primal}};
            ASSERT_EQ(image.values, s.renderer->render(s.view, 16, {100 + i, 0, 0}, s.plan, &s.result).values);
        }
        expectAgreement(statistics(guided), statistics(plain), name);
    }
}

// With directions, lights and densities at the base values, guided ones included, derivatives are those of the estimate itself: pixel
// by pixel, with the same random numbers.
TEST(GuidedDerivative, IsThatOfTheFrozenEstimate) {
    RenderConfig config = guidedConfig(4);
    config.frozenEvaluation = true;
    GuidedBench s("box", {"*.baseColor"}, 16, config);
    s.train(2, 8);
    s.plan = {.method = {Sampling::Primal}}; // as in images
    const PassKey key{7, 0, 1};
    const Image forward = s.renderer->forward(s.view, 16, key, s.config.differentiable, s.directions, s.plan, &s.result);
    const float h = 2e-3f;
    const auto shifted = [&](float step) {
        for (std::size_t i = 0; i < s.directions.size(); ++i) {
            std::vector<float> values = s.scene.parameters[s.config.differentiable[i]].values;
            for (std::size_t k = 0; k < values.size(); ++k)
                values[k] += step * s.directions[i][k];
            s.renderer->setSecondValues(s.config.differentiable[i], values);
        }
        return s.renderer->render(s.view, 16, key, s.plan, &s.result);
    };
    const Image plus = shifted(h), minus = shifted(-h);
    double difference = 0, norm = 0;
    for (std::size_t i = 0; i < forward.values.size(); ++i) {
        const double expected = (double(plus.values[i]) - minus.values[i]) / (2 * h);
        difference += (forward.values[i] - expected) * (forward.values[i] - expected);
        norm += expected * expected;
    }
    ASSERT_GT(norm, 0);
    // Images are polynomials of degree 3 in the albedo: the difference is off by h^2 of the third derivative; rounding is 1e-7 / h.
    EXPECT_LT(std::sqrt(difference / norm), 3e-4);
}

} // namespace
} // namespace cmpg::test
