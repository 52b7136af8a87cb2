// Recovers the painting of the box scene from a picture of it: recover_painting SCENE TARGET STEPS
#include <cmpg/cmpg.h>

#include <cstdio>
#include <cstdlib>

int main(int, char** arguments) try {
    cmpg::Scene scene = cmpg::Scene::load(arguments[1]);
    scene.set("painting.baseColor", std::vector{0.5f});
    cmpg::RecoveryOptions options;
    options.parameters = {"painting.baseColor"};
    options.steps = std::uint32_t(std::atoi(arguments[3]));
    cmpg::Recovery recovery(cmpg::Device(), scene, {cmpg::Target::load(arguments[2])}, options);
    double first = 0, last = 0;
    while (!recovery.done()) {
        const cmpg::RecoveryStep step = recovery.step();
        (step.step == 0 ? first : last) = step.loss;
        std::printf("step %u: loss %g +- %g\n", step.step, step.loss, step.lossError);
    }
    recovery.apply(scene);
    return last < 0.5 * first ? 0 : 1;
} catch (const cmpg::Error& error) {
    std::fprintf(stderr, "%s\n  cause: %s\n  remedy: %s\n", error.what(), error.cause.c_str(), error.remedy.c_str());
    return 2;
}
