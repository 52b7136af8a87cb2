// Names of methods and modes of a comparison.
#include "lab/compare_methods.h"
#include "base/error.h"
#include "lab/compare_subject.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

CompareMethod one(const std::string& text, const Options& base = {}) { return parseMethods(text, base).at(0); }

TEST(CompareMethods, NamesStandForOptions) {
    for (const char* name : {"plain", "bsdf"}) {
        const CompareMethod method = one(name);
        EXPECT_EQ(method.options.sampling, Sampling::Bsdf);
        EXPECT_EQ(method.options.pixelSampling, PixelSampling::Uniform);
        EXPECT_FALSE(method.options.roulette || method.options.positivize || method.learns());
        EXPECT_FALSE(method.options.noLightSampling);
    }
    const std::pair<const char*, Sampling> kinds[] = {{"primal", Sampling::Primal},
                                                      {"differential", Sampling::Differential},
                                                      {"uniform", Sampling::Uniform},
                                                      {"conditional", Sampling::Conditional}};
    for (const auto& [name, kind] : kinds) {
        const CompareMethod method = one(name);
        EXPECT_EQ(method.options.sampling, kind);
        EXPECT_EQ(method.options.pixelSampling, PixelSampling::Uniform);
        EXPECT_FALSE(method.options.roulette);
        EXPECT_TRUE(method.learns());
    }
    for (const char* name : {"ours", "auto"}) {
        const CompareMethod method = one(name);
        EXPECT_EQ(method.options.sampling, Sampling::Auto);
        EXPECT_EQ(method.options.pixelSampling, PixelSampling::Adjoint);
        EXPECT_TRUE(method.options.roulette);
    }
}

TEST(CompareMethods, PartsChangeOneThingEach) {
    const CompareMethod all = one("conditional+pixels+roulette+positivize+nonee+independent");
    EXPECT_EQ(all.options.sampling, Sampling::Conditional);
    EXPECT_EQ(all.options.pixelSampling, PixelSampling::Adjoint);
    EXPECT_TRUE(all.options.roulette && all.options.positivize);
    EXPECT_TRUE(all.options.noLightSampling);
    EXPECT_EQ(all.options.sampler, Sampler::Independent);
    const CompareMethod bare = one("ours+nopixels+noroulette");
    EXPECT_EQ(bare.options.sampling, Sampling::Auto);
    EXPECT_EQ(bare.options.pixelSampling, PixelSampling::Uniform);
    EXPECT_FALSE(bare.options.roulette);
    EXPECT_TRUE(one("plain+roulette").learns());
    Options base;
    base.noLightSampling = true;
    base.sampler = Sampler::Independent;
    EXPECT_TRUE(one("primal", base).options.noLightSampling);
    EXPECT_FALSE(one("primal+nee", base).options.noLightSampling);
    EXPECT_EQ(one("primal+sobol", base).options.sampler, Sampler::Sobol);
}

TEST(CompareMethods, ListsKeepTheirOrder) {
    const auto methods = parseMethods("plain,primal+pixels,ours", {});
    ASSERT_EQ(methods.size(), 3u);
    EXPECT_EQ(methods[1].name, "primal+pixels");
    EXPECT_EQ(methods[2].name, "ours");
}

TEST(CompareMethods, RefusesWhatItDoesNotKnow) {
    for (const char* wrong : {"", "plain,", ",plain", "magic", "plain+", "plain+magic", "plain+no", "plain,plain", "plain+nosobol", "+pixels"})
        EXPECT_THROW(parseMethods(wrong, {}), Error) << wrong;
}

TEST(CompareModes, AreAList) {
    EXPECT_EQ(parseModes("optimize,forward"), (std::vector<CompareMode>{CompareMode::Optimize, CompareMode::Forward}));
    EXPECT_EQ(parseModes("reverse,reverse").size(), 1u);
    for (const char* wrong : {"", "sideways", "forward,,reverse"})
        EXPECT_THROW(parseModes(wrong), Error) << wrong;
}

} // namespace
} // namespace cmpg
