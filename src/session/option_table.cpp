// Which options each command takes.
#include "session/option_table.h"

namespace cmpg {

std::span<const OptionGroup> groupsOf(Command command) {
    using enum OptionGroup;
    static constexpr OptionGroup open[] = {Parameters, Target, Optimizer};
    static constexpr OptionGroup render[] = {Budget, Batches, Layers};
    static constexpr OptionGroup gradient[] = {Budget, Batches, Parameters, Target, Differentiation, Check, Layers};
    static constexpr OptionGroup optimize[] = {Budget, Batches, Parameters, Target, Optimizer, RunFolder};
    static constexpr OptionGroup compare[] = {Parameters, Target, Comparison, Differentiation, Optimizer};
    static constexpr OptionGroup tradeoff[] = {Parameters, Target, Measurement, Differentiation};
    static constexpr OptionGroup inspect[] = {Parameters};
    static constexpr OptionGroup view[] = {View};
    static constexpr OptionGroup guide[] = {GuideFile};
    switch (command) {
    case Command::Open:
        return open;
    case Command::Render:
        return render;
    case Command::Gradient:
        return gradient;
    case Command::Optimize:
        return optimize;
    case Command::Compare:
        return compare;
    case Command::Tradeoff:
        return tradeoff;
    case Command::Inspect:
        return inspect;
    case Command::View:
        return view;
    case Command::Guide:
        return guide;
    case Command::None:
    case Command::ListDevices:
    case Command::Version:
        break;
    }
    return {};
}

std::vector<OptionGroup> recordedGroups(Command command) {
    std::vector<OptionGroup> groups;
    if (command != Command::View && command != Command::Guide)
        groups.assign(std::begin(kCommonGroups), std::end(kCommonGroups));
    if (command != Command::Open && command != Command::Inspect) { // they leave nothing to reproduce
        const std::span<const OptionGroup> own = groupsOf(command);
        groups.insert(groups.end(), own.begin(), own.end());
    }
    return groups;
}

} // namespace cmpg
