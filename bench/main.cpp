// Prints ratios of our speed to a yardstick's, both measured in turn in the same run, so that the machine's load matters little.
// Arguments name the parts to run: traversal, step, guiding, features. Without any, all run.
#include "bench.h"

#include <cmpg/error.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

int main(int argc, char** argv) try {
    const std::vector<std::string> parts(argv + 1, argv + argc);
    const auto wanted = [&](const char* part) { return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end(); };
    if (wanted("traversal"))
        cmpg::bench::traversal();
    if (wanted("step"))
        cmpg::bench::step(CMPG_SCENES);
    if (wanted("guiding"))
        cmpg::bench::guiding(CMPG_SCENES);
    if (wanted("features"))
        cmpg::bench::features(CMPG_SCENES);
    return 0;
} catch (const cmpg::Error& e) {
    std::fprintf(stderr, "%s\n%s\n%s\n", e.what(), e.cause.c_str(), e.remedy.c_str());
    return 1;
}
