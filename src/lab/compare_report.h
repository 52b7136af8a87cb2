// What a comparison found, as files and as parts of a report.
#pragma once

#include "lab/compare_optimize.h"

#include <filesystem>
#include <nlohmann/json.hpp>

namespace cmpg {

// Beside its figures, what is to be said of a method.
struct MethodFacts {
    double trainSeconds = 0;
    std::string chosen; // describeDecision()
};

// One mode of a comparison. CSV rows have kResultColumns and kCurveColumns.
struct ComparePart {
    std::string html;                      // a <section>
    std::string resultRows, curveRows;
    nlohmann::ordered_json table = nlohmann::ordered_json::array(); // a row per method
    std::string svg;                       // error over time
    std::vector<std::pair<std::string, Image>> images; // file name without extension -> EXR
};
inline constexpr const char* kResultColumns =
    "mode,method,passes,spp,seconds,train_seconds,mse,relative_variance,relative_variance_error,bias,bias_95,bias_z,efficiency,"
    "efficiency_error,ratio,ratio_error,image_mse,chosen\n";
inline constexpr const char* kCurveColumns = "mode,method,passes,seconds,mse\n";

ComparePart gradientPart(const CompareSubject& subject, CompareMode mode, const GradientComparison& comparison,
                         const std::vector<MethodFacts>& facts);
ComparePart optimizePart(const CompareSubject& subject, const OptimizeComparison& comparison);

// What the part found, in one sentence; HTML. Empty where nothing finite is known of methods that are not biased.
std::string headlineOf(const GradientComparison& comparison);
std::string headlineOf(const OptimizeComparison& comparison);

// Where figures relative to the reference say nothing.
void warnOfNoDerivative(const MeasuredReference& reference);

// The whole page. `device`: in words.
std::string compareDocument(const CompareSubject& subject, const std::string& device, const std::string& configuration,
                            const std::vector<ComparePart>& parts);

// Name, colour in the plot, description and choice of a method as a table's first cell; HTML.
std::string methodCell(std::size_t index, const CompareMethod& method, const std::string& chosen);
std::string csvNumber(double value); // nine digits; empty where there is none
std::string csvLine(const std::vector<std::string>& fields);

// The values of a comparison as images: the derivative image, or one per parameter. Names are parts of file names, empty for a
// single one.
std::vector<std::pair<std::string, Image>> imagesOf(const CompareSubject& subject, CompareMode mode, std::span<const double> values);

} // namespace cmpg
