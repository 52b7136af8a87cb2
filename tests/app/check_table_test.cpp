// The table that gradient --check prints.
#include "app/check_table.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

CheckResult checked(double standardError) {
    CheckResult result{.repetitions = 16, .step = 0.5, .threshold = 1e-6};
    result.comparisons.push_back({.what = "red mean", .forward = 1, .finite = 1.01, .standardError = standardError, .probability = 0.5});
    result.comparisons.push_back({.what = "block 1,2", .forward = 1, .finite = 1, .standardError = standardError, .probability = 0.9});
    result.comparisons.push_back({.what = "block 3,4", .forward = 1, .finite = 1.1, .standardError = standardError, .probability = 0.1});
    return result;
}

TEST(CheckTable, ShowsMeansAndTheWorstBlock) {
    const std::string table = checkTable(checked(0.01), "p", "one");
    EXPECT_NE(table.find("p, direction one, step 0.5, 16 repetitions\n"), std::string::npos) << table;
    EXPECT_NE(table.find("red mean"), std::string::npos);
    EXPECT_NE(table.find("block 3,4"), std::string::npos);
    EXPECT_EQ(table.find("block 1,2"), std::string::npos);
    EXPECT_NE(table.find("agrees: of 3 comparisons"), std::string::npos);
    EXPECT_EQ(table.find("weak"), std::string::npos);
}

TEST(CheckTable, SaysWhatItCannotSee) {
    EXPECT_NE(checkTable(checked(0.1), "p", "one").find("weak"), std::string::npos);
    EXPECT_NE(checkTable(checked(1), "p", "one").find("nothing to compare"), std::string::npos);
    CheckResult wrong = checked(0.01);
    wrong.comparisons[2].probability = 1e-9;
    EXPECT_NE(checkTable(wrong, "p", "one").find("DISAGREES"), std::string::npos);
}

} // namespace
} // namespace cmpg
