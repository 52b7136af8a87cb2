// One function per command. Each fills the report and returns the exit code; errors are thrown.
#pragma once

#include "app/report.h"
#include "app/exit_status.h"

namespace cmpg {

ExitStatus runRender(const Options& options, Report& report);
ExitStatus runGradient(const Options& options, Report& report);
ExitStatus runOptimize(const Options& options, Report& report);
ExitStatus runCompare(const Options& options, Report& report);
ExitStatus runInspect(const Options& options, Report& report);
ExitStatus runTradeoff(const Options& options, Report& report);
ExitStatus runView(const Options& options, Report& report);
ExitStatus runGuide(const Options& options, Report& report);
ExitStatus runListDevices(const Options& options, Report& report);
ExitStatus runVersion(const Options& options, Report& report);

} // namespace cmpg
