// The options of a recovery as the configuration of an optimisation.
#include "optimize/recovery_config.h"

namespace cmpg {

OptimizeConfig configOf(const v1::RecoveryOptions& options) {
    OptimizeConfig config;
    config.steps = options.steps;
    config.spp = options.spp;
    config.sppGradient = options.sppGradient;
    config.sppDifference = options.sppDifference;
    config.seed = options.seed;
    config.loss = options.loss;
    config.optimizer.kind = options.optimizer;
    config.optimizer.rates = OptimizerConfig{}.rates;
    for (const auto& [slot, rate] : options.rates)
        setRate(config.optimizer.rates, slot, rate);
    config.optimizer.schedule = options.schedule;
    config.optimizer.finalFactor = options.finalRate;
    config.totalVariation = double(options.totalVariation);
    config.prior = double(options.prior);
    config.viewsPerStep = options.viewsPerStep;
    config.warmUp = options.warmUp;
    return config;
}

} // namespace cmpg
