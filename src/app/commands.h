// One function per command. Each fills the report and returns the exit code; errors are thrown.
#pragma once

#include "session/exit_status.h"
#include "session/report.h"

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
