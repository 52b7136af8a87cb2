// The compiled half of the Python package: handles of the library, with arrays in place of its vectors. python/cmpg/__init__.py is the surface.
#include "errors.h"

#include <cmpg/cmpg.h>

#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Floats = nb::ndarray<const float, nb::c_contig, nb::device::cpu>;
using Array = nb::ndarray<nb::numpy, float>;

// Every call into the library lets other Python threads run: it may wait for a device that such a thread works with, and asks Python for
// signals while it holds it. That is also why the last handle must not be dropped with the lock of the interpreter held.
template <class T> struct Held {
    std::optional<T> library;

    explicit Held(T handle) : library(std::move(handle)) {}
    Held(Held&&) = default;
    ~Held() {
        nb::gil_scoped_release released;
        library.reset();
    }
};
using Device = Held<cmpg::Device>;
using Renderer = Held<cmpg::Renderer>;
using Recovery = Held<cmpg::Recovery>;

// An array that takes over the values.
template <class T> Array toArray(std::vector<T> values, int height, int width, int channels) {
    auto* kept = new std::vector<float>(values.begin(), values.end());
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<float>*>(p); });
    return Array(kept->data(), {std::size_t(height), std::size_t(width), std::size_t(channels)}, owner);
}
template <> Array toArray(std::vector<float> values, int height, int width, int channels) {
    auto* kept = new std::vector<float>(std::move(values));
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<float>*>(p); });
    return Array(kept->data(), {std::size_t(height), std::size_t(width), std::size_t(channels)}, owner);
}
Array toArray(cmpg::Image image) { return toArray(std::move(image.values), image.height, image.width, image.channels); }
template <class T> Array toArray(std::vector<T> values, const cmpg::ParameterInfo& info) {
    return toArray(std::move(values), info.height, info.width, info.channels);
}

cmpg::Image toImage(const Floats& array) {
    if (array.ndim() != 3 || (array.shape(2) != 1 && array.shape(2) != 3))
        throw cmpg::Error(cmpg::ErrorKind::Usage, "an image is an array of (height, width, 3)", {}, "reshape it");
    cmpg::Image image(int(array.shape(1)), int(array.shape(0)), int(array.shape(2)));
    std::copy_n(array.data(), array.size(), image.values.begin());
    return image;
}
std::vector<float> toVector(const Floats& array) { return {array.data(), array.data() + array.size()}; }

// The value of an enumeration with this name.
template <class E, std::size_t N> E named(const std::string& option, const std::string& name, const cmpg::EnumName<E> (&names)[N]) {
    std::string all;
    for (const auto& known : names) {
        if (name == known.name)
            return known.value;
        all += (all.empty() ? "" : ", ") + std::string(known.name);
    }
    throw cmpg::Error(cmpg::ErrorKind::Usage, option + " cannot be '" + name + "'", {}, "take one of " + all, {option});
}

template <class E, std::size_t N> const char* nameOf(E value, const cmpg::EnumName<E> (&names)[N]) {
    for (const auto& known : names)
        if (known.value == value)
            return known.name;
    return "";
}

cmpg::PathOptions pathOptions(std::uint32_t maxDepth, const std::string& sampling, const std::string& pixelSampling, const std::string& roulette,
                              bool positivize, bool noNee, std::uint64_t memory, std::uint64_t guideMemory, const std::string& sampler,
                              const std::filesystem::path& loadGuide, bool keepGuide, const std::map<std::string, double>& expert) {
    constexpr cmpg::EnumName<bool> kRoulettes[] = {{false, "off"}, {true, "adjoint"}};
    cmpg::GuideOptions guide{.load = loadGuide, .keep = keepGuide};
    bool allFeatures = false;
    for (const auto& [name, value] : expert) {
        if (name == "guide_share")
            guide.share = float(value);
        else if (name == "roulette_effort")
            guide.rouletteEffort = float(value);
        else if (name == "cell_records")
            guide.cellRecords = std::uint32_t(std::clamp(value, 0.0, 4e9));
        else if (name == "direction_share")
            guide.directionShare = value;
        else if (name == "forgetting")
            guide.forgetting = value;
        else if (name == "all_features")
            allFeatures = value != 0;
        else
            throw cmpg::Error(cmpg::ErrorKind::Usage, "there is no expert option '" + name + "'", {},
                              "take guide_share, roulette_effort, cell_records, direction_share, forgetting or all_features", {"expert"});
    }
    return {.maxDepth = maxDepth,
            .sampling = named("sampling", sampling, cmpg::kSamplings),
            .pixelSampling = named("pixel-sampling", pixelSampling, cmpg::kPixelSamplings),
            .roulette = named("roulette", roulette, kRoulettes),
            .positivize = positivize,
            .lightSampling = !noNee,
            .memory = memory,
            .guideMemory = guideMemory,
            .sampler = named("sampler", sampler, cmpg::kSamplers),
            .guide = guide,
            .allFeatures = allFeatures};
}

cmpg::PassOptions passOptions(const std::string& camera, int width, int height, std::uint32_t spp, std::uint64_t seed, std::uint32_t train,
                              std::uint32_t trainSpp, bool frozen, double errorTarget, double timeBudget, std::uint32_t batches, bool layers) {
    return {.camera = camera, .width = width, .height = height, .spp = spp, .seed = seed, .train = train, .trainSpp = trainSpp, .frozen = frozen,
            .errorTarget = errorTarget, .timeBudget = timeBudget, .batches = batches, .layers = layers};
}

// Ctrl-C ends a pass.
void endOnSignals() {
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0)
        throw nb::python_error();
}

template <class Work> auto released(Work&& work) {
    nb::gil_scoped_release unlocked;
    return work();
}

} // namespace

NB_MODULE(_cmpg, m) {
    nb::register_exception_translator(translate);

    m.def("encode_png", [](const Floats& image, float exposure) {
        const std::vector<std::uint8_t> bytes = cmpg::encodePng(toImage(image), exposure);
        return nb::bytes(bytes.data(), bytes.size());
    }, "image"_a, "exposure"_a);
    m.def("save_image", [](const std::filesystem::path& file, const Floats& image, float exposure) {
        const cmpg::Image copy = toImage(image);
        released([&] { cmpg::saveImage(file, copy, exposure); });
    }, "file"_a, "image"_a, "exposure"_a);
    m.def("load_image", [](const std::filesystem::path& file) { return toArray(released([&] { return cmpg::loadImage(file); })); }, "file"_a);

    nb::class_<cmpg::DeviceInfo>(m, "DeviceInfo", "What a driver says of a device.")
        .def_ro("name", &cmpg::DeviceInfo::name)
        .def_ro("driver", &cmpg::DeviceInfo::driver)
        .def_ro("type", &cmpg::DeviceInfo::type, "\"cpu\", \"integrated\", \"discrete\", \"virtual\" or \"other\"")
        .def_ro("usable", &cmpg::DeviceInfo::usable)
        .def_ro("missing", &cmpg::DeviceInfo::missing, "the required features it lacks, where it is not usable")
        .def("__repr__", [](const cmpg::DeviceInfo& info) {
            return "<" + info.name + ", " + info.driver + (info.usable ? "" : ", unusable: it lacks " + info.missing) + ">";
        });
    m.def("devices", [] { return released([] { return cmpg::Device::list(); }); });

    nb::class_<Device>(m, "Device")
        .def("__init__", [](Device* self, const std::string& select) {
            new (self) Device(released([&] { return cmpg::Device(select); }));
        }, "select"_a)
        .def("info", [](const Device& self) { return self.library->info(); })
        .def("memory_in_use", [](const Device& self) { return released([&] { return self.library->memoryInUse(); }); })
        .def("memory_peak", [](const Device& self) { return released([&] { return self.library->memoryPeak(); }); });

    nb::class_<cmpg::ParameterInfo>(m, "ParameterInfo")
        .def_ro("name", &cmpg::ParameterInfo::name)
        .def_ro("slot", &cmpg::ParameterInfo::slot)
        .def_prop_ro("shape", [](const cmpg::ParameterInfo& info) { return nb::make_tuple(info.height, info.width, info.channels); })
        .def_ro("lowest", &cmpg::ParameterInfo::lowest)
        .def_ro("highest", &cmpg::ParameterInfo::highest);

    nb::class_<cmpg::Scene>(m, "Scene")
        .def("__init__", [](cmpg::Scene* self, const std::filesystem::path& file, const std::filesystem::path& environment, float rotation,
                            const std::map<std::string, std::string>& define) {
            new (self) cmpg::Scene(released([&] { return cmpg::Scene::load(file, {environment, rotation, define}); }));
        }, "file"_a, "environment"_a, "environment_rotation"_a, "define"_a)
        .def("copy", &cmpg::Scene::copy, nb::call_guard<nb::gil_scoped_release>())
        .def("source", &cmpg::Scene::source)
        .def("warnings", &cmpg::Scene::warnings)
        .def("max_depth", &cmpg::Scene::maxDepth)
        .def("cameras", [](const cmpg::Scene& self) {
            std::vector<std::pair<std::string, std::optional<float>>> cameras;
            for (const cmpg::CameraInfo& camera : self.cameras())
                cameras.emplace_back(camera.name, camera.aspect);
            return cameras;
        })
        .def("parameters", [](const cmpg::Scene& self) { return released([&] { return self.parameters(); }); })
        .def("parameter", [](const cmpg::Scene& self, const std::string& name) { return released([&] { return self.parameter(name); }); }, "name"_a)
        .def("select", &cmpg::Scene::select, "glob"_a)
        .def("values", [](const cmpg::Scene& self, const std::string& name) {
            const cmpg::ParameterInfo info = released([&] { return self.parameter(name); });
            return toArray(released([&] { return self.values(name); }), info);
        }, "name"_a)
        .def("set", [](cmpg::Scene& self, const std::string& name, const Floats& values) {
            released([&] { self.set(name, std::span(values.data(), values.size())); });
        }, "name"_a, "values"_a)
        .def("export", &cmpg::Scene::exportTo, "folder"_a, nb::call_guard<nb::gil_scoped_release>());

    nb::class_<cmpg::PathOptions>(m, "PathOptions")
        .def("__init__", [](cmpg::PathOptions* self, std::uint32_t maxDepth, const std::string& sampling, const std::string& pixelSampling,
                            const std::string& roulette, bool positivize, bool noNee, std::uint64_t memory, std::uint64_t guideMemory,
                            const std::string& sampler, const std::filesystem::path& loadGuide, bool keepGuide, const std::map<std::string, double>& expert) {
            new (self) cmpg::PathOptions(pathOptions(maxDepth, sampling, pixelSampling, roulette, positivize, noNee, memory, guideMemory, sampler, loadGuide,
                                                     keepGuide, expert));
        }, "max_depth"_a, "sampling"_a, "pixel_sampling"_a, "roulette"_a, "positivize"_a, "no_nee"_a, "memory"_a, "guide_memory"_a, "sampler"_a,
           "load_guide"_a, "keep_guide"_a, "expert"_a);
    nb::class_<cmpg::PassOptions>(m, "PassOptions")
        .def("__init__", [](cmpg::PassOptions* self, const std::string& camera, int width, int height, std::uint32_t spp, std::uint64_t seed,
                            std::uint32_t train, std::uint32_t trainSpp, bool frozen, double errorTarget, double timeBudget, std::uint32_t batches,
                            bool layers) {
            new (self) cmpg::PassOptions(
                passOptions(camera, width, height, spp, seed, train, trainSpp, frozen, errorTarget, timeBudget, batches, layers));
        }, "camera"_a, "width"_a, "height"_a, "spp"_a, "seed"_a, "train"_a, "train_spp"_a, "frozen"_a, "error_target"_a, "time_budget"_a, "batches"_a,
           "layers"_a);
    nb::class_<cmpg::PassReport>(m, "PassReport", "What a pass did.")
        .def_ro("width", &cmpg::PassReport::width)
        .def_ro("height", &cmpg::PassReport::height)
        .def_ro("spp", &cmpg::PassReport::spp, "samples per pixel of the result, of all batches")
        .def_ro("batches", &cmpg::PassReport::batches, "0: samples were not divided, and nothing tells the error")
        .def_prop_ro("error", [](const cmpg::PassReport& r) { return r.error.relative; }, "|standard error| / |result|, over all pixels or texels")
        .def_prop_ro("error_low", [](const cmpg::PassReport& r) { return r.error.low; }, "|result - truth| / |result| is at least this ...")
        .def_prop_ro("error_high", [](const cmpg::PassReport& r) { return r.error.high; }, "... and at most this, with 95 % confidence")
        .def_prop_ro("end", [](const cmpg::PassReport& r) {
            return r.end == cmpg::BudgetEnd::Error ? "error" : r.end == cmpg::BudgetEnd::Time ? "time" : "samples";
        }, "what was reached or used up: \"error\", \"time\" or \"samples\"")
        .def_ro("seconds", &cmpg::PassReport::seconds, "wall, of the pass; without learning and compilation")
        .def_ro("learning_seconds", &cmpg::PassReport::learningSeconds)
        .def_ro("paths", &cmpg::PassReport::paths, "camera paths, those of learning passes included")
        .def_ro("rays", &cmpg::PassReport::rays)
        .def_ro("dropped", &cmpg::PassReport::dropped, "contributions left out, by kind: not finite, or too large to be summed")
        .def_ro("refused_splits", &cmpg::PassReport::refusedSplits, "of the guide's cells, for want of memory")
        .def_ro("guided", &cmpg::PassReport::guided, "there is a guide")
        .def_prop_ro("sampling", [](const cmpg::PassReport& r) { return nameOf(r.sampling, cmpg::kSamplings); }, "how directions were drawn")
        .def_ro("roulette", &cmpg::PassReport::roulette)
        .def_prop_ro("figures", [](const cmpg::PassReport& r) {
            nb::list figures;
            for (const cmpg::MethodFigures& f : r.figures) {
                nb::dict figure;
                figure["sampling"] = nameOf(f.sampling, cmpg::kSamplings);
                figure["roulette"] = f.roulette;
                figure["variance"] = f.variance;
                figure["rays_per_path"] = f.raysPerPath;
                figure["passes"] = f.passes;
                figures.append(figure);
            }
            return figures;
        }, "what learning passes measured of each method")
        .def("layers", [](const cmpg::PassReport& r) {
            nb::dict layers;
            const auto add = [&](const std::string& name, const cmpg::Image& image) {
                if (image.width > 0)
                    layers[name.c_str()] = toArray(image);
            };
            add("normal", r.layers.normal);
            add("depth", r.layers.depth);
            add("albedo", r.layers.albedo);
            add("samples", r.layers.samples);
            if (r.guided) {
                add("guided", r.layers.guided);
                add("dead", r.layers.dead);
                add("cell", r.layers.cell);
                for (std::size_t d = 0; d < r.layers.lightShare.size(); ++d)
                    add("light_share" + std::to_string(d + 1), r.layers.lightShare[d]);
            }
            return layers;
        });

    nb::class_<Renderer>(m, "Renderer")
        .def("__init__", [](Renderer* self, const Device& device, const cmpg::Scene& scene, const std::vector<std::string>& parameters,
                            const cmpg::PathOptions& paths) {
            new (self) Renderer(released([&] {
                cmpg::Renderer renderer(*device.library, scene, {.paths = paths, .parameters = parameters});
                renderer.onSubmission(endOnSignals);
                return renderer;
            }));
        }, "device"_a, "scene"_a, "parameters"_a, "paths"_a)
        .def("parameters", [](const Renderer& self) { return self.library->parameters(); })
        .def("render", [](Renderer& self, const cmpg::PassOptions& pass) {
            cmpg::PassReport report;
            return std::pair(toArray(released([&] { return self.library->render(pass, &report); })), report);
        }, "options"_a)
        .def("forward", [](Renderer& self, const std::vector<std::pair<std::string, Floats>>& given, const cmpg::PassOptions& pass) {
            std::vector<cmpg::Direction> directions;
            for (const auto& [name, values] : given)
                directions.push_back({name, toVector(values)});
            cmpg::PassReport report;
            return std::pair(toArray(released([&] { return self.library->forward(directions, pass, &report); })), report);
        }, "directions"_a, "options"_a)
        .def("backward", [](Renderer& self, const Floats& adjoint, const cmpg::PassOptions& pass) {
            const cmpg::Image image = toImage(adjoint);
            cmpg::PassReport report;
            const std::vector<std::vector<double>> gradients = released([&] { return self.library->backward(image, pass, &report); });
            const std::vector<cmpg::ParameterInfo> infos = self.library->parameters();
            nb::dict result;
            for (std::size_t i = 0; i < infos.size(); ++i)
                result[infos[i].name.c_str()] = toArray(gradients[i], infos[i]);
            return std::pair(result, report);
        }, "adjoint"_a, "options"_a)
        .def("check", [](Renderer& self, const std::string& name, const Floats& values, const cmpg::PassOptions& pass, std::uint32_t sppGradient) {
            const cmpg::Direction direction{name, toVector(values)};
            const cmpg::CheckResult found = released([&] { return self.library->check(direction, pass, sppGradient); });
            nb::dict result;
            result["agrees"] = found.agrees();
            result["step"] = found.step;
            result["threshold"] = found.threshold;
            nb::list comparisons;
            for (const cmpg::Comparison& c : found.comparisons) {
                nb::dict comparison;
                comparison["what"] = c.what;
                comparison["forward"] = c.forward;
                comparison["finite"] = c.finite;
                comparison["standard_error"] = c.standardError;
                comparison["relative_error"] = c.relativeError();
                comparison["power"] = c.power();
                comparison["probability"] = c.probability;
                comparisons.append(comparison);
            }
            result["comparisons"] = comparisons;
            return result;
        }, "parameter"_a, "direction"_a, "options"_a, "spp_gradient"_a)
        .def("save_guide", [](const Renderer& self, const std::filesystem::path& file) { released([&] { self.library->saveGuide(file); }); }, "file"_a);

    nb::class_<cmpg::Target>(m, "Target")
        .def("__init__", [](cmpg::Target* self, const Floats& image, const std::string& camera, const std::optional<Floats>& mask) {
            new (self) cmpg::Target{camera, toImage(image), mask ? toVector(*mask) : std::vector<float>()};
        }, "image"_a, "camera"_a, "mask"_a.none())
        .def_static("load", [](const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
            return released([&] { return cmpg::Target::load(file, camera, mask, exposure); });
        }, "file"_a, "camera"_a, "mask"_a, "exposure"_a);

    nb::class_<cmpg::RecoveryStep>(m, "RecoveryStep", "What one step did.")
        .def_ro("step", &cmpg::RecoveryStep::step, "number of the step, from 0")
        .def_ro("loss", &cmpg::RecoveryStep::loss,
                "mean over the views, before the update; of a squared loss without bias by noise, so it may be negative")
        .def_ro("loss_error", &cmpg::RecoveryStep::lossError, "standard error of `loss` by noise")
        .def_ro("regularizer", &cmpg::RecoveryStep::regularizer, "weighted; no part of `loss`")
        .def_ro("rate", &cmpg::RecoveryStep::rate, "of the first parameter, schedule included")
        .def_ro("seconds", &cmpg::RecoveryStep::seconds, "wall seconds of the step")
        .def_ro("gradient_norm", &cmpg::RecoveryStep::gradientNorm, "Euclidean, over all parameters")
        .def_ro("dropped", &cmpg::RecoveryStep::dropped, "entries and pixels left out because they were not finite")
        .def_ro("warnings", &cmpg::RecoveryStep::warnings, "gradients that explode, stall or come from a few samples, each told once")
        .def("__repr__", [](const cmpg::RecoveryStep& step) {
            char text[160];
            std::snprintf(text, sizeof text, "<step %u: loss %.4g +- %.2g, %.2f s>", step.step, step.loss, step.lossError, step.seconds);
            return std::string(text);
        });

    nb::class_<Recovery>(m, "Recovery")
        .def("__init__", [](Recovery* self, const Device& device, const cmpg::Scene& scene, const std::vector<cmpg::Target>& targets,
                            const std::vector<std::string>& parameters, const cmpg::PathOptions& paths, std::uint32_t steps, std::uint32_t spp,
                            std::uint32_t sppGradient, std::uint32_t sppDifference, std::uint64_t seed, const std::string& loss,
                            const std::string& optimizer, const std::vector<std::pair<std::string, float>>& rates, const std::string& schedule,
                            float finalRate, float prior, float totalVariation, std::uint32_t viewsPerStep, std::uint32_t warmUp,
                            std::uint32_t freeze, double errorTarget) {
            const cmpg::RecoveryOptions options{.paths = paths,
                                                .parameters = parameters,
                                                .steps = steps,
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
            new (self) Recovery(released([&] {
                cmpg::Recovery recovery(*device.library, scene, targets, options);
                recovery.onSubmission(endOnSignals);
                return recovery;
            }));
        }, "device"_a, "scene"_a, "targets"_a, "parameters"_a, "paths"_a, "steps"_a, "spp"_a, "spp_gradient"_a, "spp_difference"_a, "seed"_a,
           "loss"_a, "optimizer"_a, "rates"_a, "schedule"_a, "final_rate"_a, "prior"_a, "total_variation"_a, "views_per_step"_a, "warm_up"_a, "freeze"_a, "error_target"_a)
        .def("step", [](Recovery& self) { return released([&] { return self.library->step(); }); })
        .def("steps", [](const Recovery& self) { return released([&] { return self.library->steps(); }); })
        .def("done", [](const Recovery& self) { return released([&] { return self.library->done(); }); })
        .def("parameters", [](const Recovery& self) { return self.library->parameters(); })
        .def("values", [](const Recovery& self, const cmpg::ParameterInfo& info) {
            return toArray(released([&] { return self.library->values(info.name); }), info);
        }, "parameter"_a)
        .def("gradient", [](const Recovery& self, const cmpg::ParameterInfo& info) {
            return toArray(released([&] { return self.library->gradient(info.name); }), info);
        }, "parameter"_a)
        .def("image", [](Recovery& self, std::size_t target, std::uint32_t spp) {
            return toArray(released([&] { return self.library->image(target, spp); }));
        }, "target"_a, "spp"_a)
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
        .def("save", [](const Recovery& self, const std::filesystem::path& folder) { released([&] { self.library->save(folder); }); }, "folder"_a)
        .def("resume", [](Recovery& self, const std::filesystem::path& folder) {
            return released([&] { return self.library->resume(folder); });
        }, "folder"_a);
}
