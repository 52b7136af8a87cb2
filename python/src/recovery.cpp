// Targets, steps and recoveries of the module.
#include "handles.h"

void bindRecovery(nb::module_& m) {
    nb::class_<cmpg::Target>(m, "Target")
        .def("__init__", [](cmpg::Target* self, const Floats& image, const std::string& camera, const std::optional<Floats>& mask) {
            new (self) cmpg::Target{camera, toImage(image), mask ? toVector(*mask) : std::vector<float>()};
        }, "image"_a, "camera"_a, "mask"_a.none())
        .def("move", [](cmpg::Target& self, const cmpg::CameraInfo& camera) { self.from = camera; }, "camera"_a)
        .def_static("load", [](const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
            return released([&] { return cmpg::Target::load(file, camera, mask, exposure); });
        }, "file"_a, "camera"_a, "mask"_a, "exposure"_a)
        .def_static("stream", [](const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
            return released([&] { return cmpg::Target::stream(file, camera, mask, exposure); });
        }, "file"_a, "camera"_a, "mask"_a, "exposure"_a)
        .def("averaged", [](const cmpg::Target& self, int width, int height) { return released([&] { return self.averaged(width, height); }); }, "width"_a, "height"_a)
        .def_prop_ro("nbytes", [](const cmpg::Target& target) { return (target.image.values.size() + target.mask.size()) * sizeof(float) + target.clipped.size(); })
        .def_ro_static("most_bytes", &cmpg::Target::kMostBytes);

    m.def("loss_of", [](const std::string& loss, const Floats& image, const cmpg::Target& target) {
        const cmpg::Loss kind = named("loss", loss, cmpg::kLosses);
        const cmpg::Image seen = toImage(image);
        cmpg::ImageLoss found = released([&] { return cmpg::lossOf(kind, seen, target); });
        return std::pair(found.value, toArray(std::move(found.adjoint)));
    }, "loss"_a, "image"_a, "target"_a);

    nb::class_<cmpg::RecoveryStep>(m, "RecoveryStep", "What one step did.")
        .def_ro("step", &cmpg::RecoveryStep::step, "number of the step, from 0")
        .def_ro("loss", &cmpg::RecoveryStep::loss,
                "mean over the views, before the update; of a squared loss without bias by noise, so it may be negative")
        .def_ro("loss_error", &cmpg::RecoveryStep::lossError, "standard error of `loss` by noise")
        .def_ro("regularizer", &cmpg::RecoveryStep::regularizer, "weighted; no part of `loss`")
        .def_ro("rate", &cmpg::RecoveryStep::rate, "of the first parameter, schedule included")
        .def_ro("seconds", &cmpg::RecoveryStep::seconds, "wall seconds of the step")
        .def_ro("image_seconds", &cmpg::RecoveryStep::imageSeconds, "of them, for the image")
        .def_ro("gradient_seconds", &cmpg::RecoveryStep::gradientSeconds, "of them, for the derivative pass")
        .def_ro("compile_seconds", &cmpg::RecoveryStep::compileSeconds, "of them, in which kernels were compiled, about; 0 in `history`")
        .def_ro("gradient_norm", &cmpg::RecoveryStep::gradientNorm, "Euclidean, over all parameters")
        .def_ro("dropped", &cmpg::RecoveryStep::dropped, "entries and pixels left out because they were not finite")
        .def_ro("next_seconds", &cmpg::RecoveryStep::nextSeconds, "that the next step is expected to take: as the last five, by its number of views and what it measures; and to compile what it lacks")
        .def_prop_ro("warnings", [](const cmpg::RecoveryStep& step) {
            std::vector<std::string> texts;
            for (const cmpg::Warning& warning : step.warnings)
                texts.push_back(warning.text);
            return texts;
        }, "gradients that explode, stall or come from a few samples, each told once")
        .def("__repr__", [](const cmpg::RecoveryStep& step) {
            char text[160];
            std::snprintf(text, sizeof text, "<step %u: loss %.4g +- %.2g, %.2f s>", step.step, step.loss, step.lossError, step.seconds);
            return std::string(text);
        });

    nb::class_<cmpg::RecoveryOptions>(m, "RecoveryOptions")
        .def("__init__", [](cmpg::RecoveryOptions* self, std::uint32_t steps, std::uint32_t spp, std::uint32_t sppGradient, std::uint32_t sppDifference,
                            std::uint64_t seed, const std::string& loss, const std::string& optimizer,
                            const std::vector<std::pair<std::string, float>>& rates, const std::string& schedule, float finalRate, float prior,
                            float totalVariation, std::uint32_t viewsPerStep, std::uint32_t warmUp, std::uint32_t freeze, double errorTarget) {
            new (self) cmpg::RecoveryOptions{.steps = steps,
                                             .spp = spp,
                                             .sppGradient = sppGradient,
                                             .sppDifference = sppDifference,
                                             .seed = seed,
                                             .loss = named("loss", loss, cmpg::kLosses),
                                             .optimizer = named("optimizer", optimizer, cmpg::kOptimizers),
                                             .rates = rates,
                                             .schedule = named("schedule", schedule, cmpg::kSchedules),
                                             .finalRate = finalRate,
                                             .prior = prior,
                                             .totalVariation = totalVariation,
                                             .viewsPerStep = viewsPerStep,
                                             .warmUp = warmUp,
                                             .freeze = freeze,
                                             .errorTarget = errorTarget};
        }, "steps"_a, "spp"_a, "spp_gradient"_a, "spp_difference"_a, "seed"_a, "loss"_a, "optimizer"_a, "rates"_a, "schedule"_a, "final_rate"_a,
           "prior"_a, "total_variation"_a, "views_per_step"_a, "warm_up"_a, "freeze"_a, "error_target"_a);

    nb::class_<cmpg::RecoveryProgress>(m, "RecoveryProgress", "What another recovery can go on from: the steps done, and what the optimiser knows of each parameter.");

    nb::class_<Recovery>(m, "Recovery")
        .def("__init__", [](Recovery* self, const Device& device, const cmpg::Scene& scene, const std::vector<cmpg::Target>& targets,
                            const std::vector<std::string>& parameters, const cmpg::PathOptions& paths, cmpg::RecoveryOptions options) {
            options.parameters = parameters;
            options.paths = paths;
            new (self) Recovery(released([&] {
                cmpg::Recovery recovery(*device.library, scene, targets, options);
                recovery.onSubmission(endOnSignals);
                return recovery;
            }));
        }, "device"_a, "scene"_a, "targets"_a, "parameters"_a, "paths"_a, "options"_a)
        .def("__init__", [](Recovery* self, const Renderer& renderer, const std::vector<cmpg::Target>& targets, const cmpg::RecoveryOptions& options,
                            const std::optional<cmpg::RecoveryProgress>& progress) {
            new (self) Recovery(released([&] {
                return cmpg::Recovery(*renderer.library, targets, options, progress.value_or(cmpg::RecoveryProgress{})); // which ends on signals
            }));
        }, "renderer"_a, "targets"_a, "options"_a, "progress"_a.none())
        .def("ended", [](const Recovery& self) { return released([&] { return self.library->ended(); }); })
        .def("progress", [](const Recovery& self) { return released([&] { return self.library->progress(); }); })
        .def("on_submission", [](Recovery& self, nb::object call, double seconds) {
            released([&] { self.library->onSubmission(onSubmission(std::move(call)), seconds); });
        }, "call"_a.none(), "seconds"_a)
        .def("on_image", [](Recovery& self, nb::object call) {
            std::function<void(std::size_t, const cmpg::Image&)> function;
            if (!call.is_none())
                function = [call = kept(std::move(call))](std::size_t target, const cmpg::Image& image) {
                    const nb::gil_scoped_acquire gil;
                    (*call)(target, toArray(image));
                };
            released([&] { self.library->onImage(std::move(function)); });
        }, "call"_a.none())
        .def("set_samples", [](Recovery& self, std::uint32_t spp, std::uint32_t sppGradient) {
            released([&] { self.library->setSamples(spp, sppGradient); });
        }, "spp"_a, "spp_gradient"_a)
        .def("set_rate_factor", [](Recovery& self, double factor) { released([&] { self.library->setRateFactor(factor); }); }, "factor"_a)
        .def("step", [](Recovery& self) { return released([&] { return self.library->step(); }); })
        .def("steps", [](const Recovery& self) { return released([&] { return self.library->steps(); }); })
        .def("done", [](const Recovery& self) { return released([&] { return self.library->done(); }); })
        .def("history", [](const Recovery& self) { return released([&] { return self.library->history(); }); })
        .def("report", [](const Recovery& self) { return released([&] { return self.library->report(); }); })
        .def("parameters", [](const Recovery& self) { return released([&] { return self.library->parameters(); }); })
        .def("values", [](const Recovery& self, const std::string& name) {
            cmpg::ParameterInfo info;
            std::vector<float> values = released([&] { return self.library->values(name, &info); });
            return toArray(std::move(values), info);
        }, "parameter"_a)
        .def("gradient", [](const Recovery& self, const cmpg::ParameterInfo& info) {
            return toArray(released([&] { return self.library->gradient(info.name); }), info);
        }, "parameter"_a)
        .def("image", [](Recovery& self, std::size_t target, std::uint32_t spp, bool initial) {
            return toArray(released([&] { return self.library->image(target, spp, initial); }));
        }, "target"_a, "spp"_a, "initial"_a)
        .def("image_into", [](Recovery& self, Film& film, std::size_t target, std::uint32_t spp) {
            cmpg::PassReport report;
            released([&] { self.library->image(film, target, spp, &report); });
            return report;
        }, "film"_a, "target"_a, "spp"_a)
        .def("target", [](const Recovery& self, std::size_t target) { return toArray(released([&] { return self.library->target(target); })); }, "target"_a)
        .def("errors", [](const Recovery& self) {
            const cmpg::GradientErrors errors = released([&] { return self.library->errors(); });
            nb::dict result;
            result["gradients"] = errors.gradients;
            result["missed"] = errors.missed;
            result["worst"] = errors.worst;
            return result;
        })
        .def("save_guide", [](const Recovery& self, const std::filesystem::path& file) { released([&] { self.library->saveGuide(file); }); }, "file"_a)
        .def("apply", [](const Recovery& self, cmpg::Scene& scene) { released([&] { self.library->apply(scene); }); }, "scene"_a)
        .def("save", [](const Recovery& self, const std::filesystem::path& folder, const std::string& note) {
            released([&] { self.library->save(folder, note); });
        }, "folder"_a, "note"_a)
        .def_static("note", [](const std::filesystem::path& folder) { return released([&] { return cmpg::Recovery::note(folder); }); }, "folder"_a)
        .def("resume", [](Recovery& self, const std::filesystem::path& folder) {
            return released([&] { return self.library->resume(folder); });
        }, "folder"_a);
}
