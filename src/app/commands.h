// One function per command. Each fills the report and returns the exit code; errors are thrown.
#pragma once

#include "app/report.h"
#include "base/error.h"

namespace cmpg {

ExitCode runRender(const Options& options, Report& report);
ExitCode runGradient(const Options& options, Report& report);
ExitCode runOptimize(const Options& options, Report& report);
ExitCode runCompare(const Options& options, Report& report);
ExitCode runInspect(const Options& options, Report& report);
ExitCode runTradeoff(const Options& options, Report& report);
ExitCode runView(const Options& options, Report& report);
ExitCode runGuide(const Options& options, Report& report);
ExitCode runListDevices(const Options& options, Report& report);
ExitCode runVersion(const Options& options, Report& report);

} // namespace cmpg
