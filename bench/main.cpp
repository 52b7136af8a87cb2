// Prints ratios of our speed to a yardstick's, both measured in turn in the same run, so that the machine's load matters little.
#include "base/error.h"
#include "bench.h"

#include <cstdio>

int main() try {
    cmpg::bench::traversal();
    cmpg::bench::step(CMPG_SCENES);
    return 0;
} catch (const cmpg::Error& e) {
    std::fprintf(stderr, "%s\n%s\n%s\n", e.what(), e.cause.c_str(), e.remedy.c_str());
    return int(e.code);
}
