// Options of passes, what they report, and renderers of the module.
#include "handles.h"

namespace {

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

cmpg::PassOptions passOptions(const std::string& camera, const std::optional<cmpg::CameraInfo>& from, int width, int height, std::uint32_t spp,
                              std::uint64_t seed, std::uint32_t train, std::uint32_t trainSpp, bool anew, bool frozen, double errorTarget, double timeBudget,
                              std::uint32_t batches, bool layers) {
    return {.camera = camera, .from = from, .width = width, .height = height, .spp = spp, .seed = seed, .train = train, .trainSpp = trainSpp,
            .anew = anew, .frozen = frozen, .errorTarget = errorTarget, .timeBudget = timeBudget, .batches = batches, .layers = layers};
}

void bindOptions(nb::module_& m) {
    nb::class_<cmpg::PathOptions>(m, "PathOptions")
        .def("__init__", [](cmpg::PathOptions* self, std::uint32_t maxDepth, const std::string& sampling, const std::string& pixelSampling,
                            const std::string& roulette, bool positivize, bool noNee, std::uint64_t memory, std::uint64_t guideMemory,
                            const std::string& sampler, const std::filesystem::path& loadGuide, bool keepGuide, const std::map<std::string, double>& expert) {
            new (self) cmpg::PathOptions(pathOptions(maxDepth, sampling, pixelSampling, roulette, positivize, noNee, memory, guideMemory, sampler, loadGuide,
                                                     keepGuide, expert));
        }, "max_depth"_a, "sampling"_a, "pixel_sampling"_a, "roulette"_a, "positivize"_a, "no_nee"_a, "memory"_a, "guide_memory"_a, "sampler"_a,
           "load_guide"_a, "keep_guide"_a, "expert"_a);
    nb::class_<cmpg::PassOptions>(m, "PassOptions")
        .def("__init__", [](cmpg::PassOptions* self, const std::string& camera, const std::optional<cmpg::CameraInfo>& from, int width, int height,
                            std::uint32_t spp, std::uint64_t seed, std::uint32_t train, std::uint32_t trainSpp, bool anew, bool frozen,
                            double errorTarget, double timeBudget, std::uint32_t batches, bool layers) {
            new (self) cmpg::PassOptions(
                passOptions(camera, from, width, height, spp, seed, train, trainSpp, anew, frozen, errorTarget, timeBudget, batches, layers));
        }, "camera"_a, "moved"_a.none(), "width"_a = 0, "height"_a = 0, "spp"_a = 0, "seed"_a = 0, "train"_a = 0, "train_spp"_a = 0, "anew"_a = true,
           "frozen"_a = false, "error_target"_a = 0.0, "time_budget"_a = 0.0, "batches"_a = 0, "layers"_a = false);
}

void bindReport(nb::module_& m) {
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
        .def_prop_ro("figures", [](const cmpg::PassReport& r) { return toList(r.figures); }, "what learning passes measured of each method")
        .def("layers", [](const cmpg::PassReport& r) { return toArrays(r.layers, r.guided); },
             "what the camera sees first, where the pass was told to keep it: arrays of (height, width, channels)");
}

void bindFilm(nb::module_& m) {
    nb::class_<Film>(m, "Film")
        .def(nb::init<int, int, bool>(), "width"_a, "height"_a, "layers"_a)
        .def("width", &Film::width)
        .def("height", &Film::height)
        .def("samples", [](const Film& self) { return released([&] { return self.samples(); }); })
        .def("image", [](const Film& self) { return toArray(released([&] { return self.image(); })); })
        .def("layers", [](const Film& self) { return toArrays(released([&] { return self.layers(); }), true); });
}

constexpr cmpg::EnumName<cmpg::PassKind> kPassKinds[] = {
    {cmpg::PassKind::Render, "render"}, {cmpg::PassKind::Forward, "forward"}, {cmpg::PassKind::Backward, "backward"}};

using Directions = std::vector<std::pair<std::string, Floats>>;

std::vector<cmpg::Direction> toDirections(const Directions& given) {
    std::vector<cmpg::Direction> directions;
    for (const auto& [name, values] : given)
        directions.push_back({name, toVector(values)});
    return directions;
}

// Of one pass, which outlives neither the function nor what it is called with.
std::function<void(const cmpg::Image&)> forImages(const nb::object& call) {
    if (call.is_none())
        return {};
    return [&call](const cmpg::Image& image) {
        const nb::gil_scoped_acquire gil;
        call(toArray(image));
    };
}

} // namespace

nb::list toList(const std::vector<cmpg::MethodFigures>& figures) {
    nb::list list;
    for (const cmpg::MethodFigures& f : figures) {
        nb::dict figure;
        figure["sampling"] = nameOf(f.sampling, cmpg::kSamplings);
        figure["roulette"] = f.roulette;
        figure["variance"] = f.variance;
        figure["rays_per_path"] = f.raysPerPath;
        figure["passes"] = f.passes;
        list.append(figure);
    }
    return list;
}

nb::dict toArrays(cmpg::Layers layers, bool guided) {
    nb::dict arrays;
    const auto add = [&](const std::string& name, cmpg::Image& image) {
        if (image.width > 0)
            arrays[name.c_str()] = toArray(std::move(image));
    };
    add("normal", layers.normal);
    add("depth", layers.depth);
    add("albedo", layers.albedo);
    add("samples", layers.samples);
    if (!guided)
        return arrays;
    add("guided", layers.guided);
    add("dead", layers.dead);
    add("cell", layers.cell);
    for (std::size_t d = 0; d < layers.lightShare.size(); ++d)
        add("light_share" + std::to_string(d + 1), layers.lightShare[d]);
    return arrays;
}

void bindRenderer(nb::module_& m) {
    bindOptions(m);
    bindReport(m);
    bindFilm(m);
    nb::class_<Renderer>(m, "Renderer")
        .def("__init__", [](Renderer* self, const Device& device, const cmpg::Scene& scene, const std::vector<std::string>& parameters,
                            const cmpg::PathOptions& paths, bool recoveries) {
            new (self) Renderer(released([&] {
                cmpg::Renderer renderer(*device.library, scene, {.paths = paths, .parameters = parameters, .recoveries = recoveries});
                renderer.onSubmission(endOnSignals);
                return renderer;
            }));
        }, "device"_a, "scene"_a, "parameters"_a, "paths"_a, "recoveries"_a)
        .def("parameters", [](const Renderer& self) { return self.library->parameters(); })
        .def("on_submission", [](Renderer& self, nb::object call, double seconds) {
            released([&] { self.library->onSubmission(onSubmission(std::move(call)), seconds); });
        }, "call"_a.none(), "seconds"_a)
        .def("render", [](Renderer& self, cmpg::PassOptions pass, const nb::object& onImage) {
            cmpg::PassReport report;
            pass.onImage = forImages(onImage);
            return std::pair(toArray(released([&] { return self.library->render(pass, &report); })), report);
        }, "options"_a, "on_image"_a.none())
        .def("forward", [](Renderer& self, const Directions& given, cmpg::PassOptions pass, const nb::object& onImage) {
            const std::vector<cmpg::Direction> directions = toDirections(given);
            cmpg::PassReport report;
            pass.onImage = forImages(onImage);
            return std::pair(toArray(released([&] { return self.library->forward(directions, pass, &report); })), report);
        }, "directions"_a, "options"_a, "on_image"_a.none())
        .def("render_into", [](Renderer& self, Film& film, const cmpg::PassOptions& pass) {
            cmpg::PassReport report;
            released([&] { self.library->render(film, pass, &report); });
            return report;
        }, "film"_a, "options"_a)
        .def("forward_into", [](Renderer& self, Film& film, const Directions& given, const cmpg::PassOptions& pass) {
            const std::vector<cmpg::Direction> directions = toDirections(given);
            cmpg::PassReport report;
            released([&] { self.library->forward(film, directions, pass, &report); });
            return report;
        }, "film"_a, "directions"_a, "options"_a)
        .def("train", [](Renderer& self, const Directions& given, const cmpg::PassOptions& pass) {
            const std::vector<cmpg::Direction> directions = toDirections(given);
            released([&] { directions.empty() ? self.library->train(pass) : self.library->train(directions, pass); });
        }, "directions"_a, "options"_a)
        .def("forget", [](Renderer& self) { released([&] { self.library->forget(); }); })
        .def("set_sampling", [](Renderer& self, const std::string& sampling) {
            const cmpg::Sampling value = named("sampling", sampling, cmpg::kSamplings);
            released([&] { self.library->setSampling(value); });
        }, "sampling"_a)
        .def("footprint", [](Renderer& self, const std::vector<std::string>& kinds, const cmpg::PassOptions& pass) {
            std::vector<cmpg::PassKind> wanted;
            for (const std::string& kind : kinds)
                wanted.push_back(named("kinds", kind, kPassKinds));
            const cmpg::Footprint found = released([&] { return self.library->footprint(wanted, pass); });
            nb::dict result, features, buffers;
            for (const auto& [name, value] : found.features)
                features[name.c_str()] = value;
            for (const auto& [name, bytes] : found.buffers)
                buffers[name.c_str()] = bytes;
            nb::list kernels;
            for (const cmpg::Footprint::Kernel& k : found.kernels) {
                nb::dict kernel;
                kernel["kind"] = nameOf(k.kind, kPassKinds);
                kernel["name"] = k.name;
                kernel["bytes"] = k.bytes;
                kernel["module_bytes"] = k.moduleBytes;
                kernels.append(kernel);
            }
            result["features"] = features;
            result["kernels"] = kernels;
            result["buffers"] = buffers;
            return result;
        }, "kinds"_a, "options"_a)
        .def("guide_at", [](const Renderer& self, const std::vector<float>& position, const std::string& kind) {
            const std::array<float, 3> place = toPoint(position);
            const cmpg::PassKind of = named("kind", kind, kPassKinds);
            return released([&] { return self.library->guideAt(place, of); });
        }, "position"_a, "kind"_a)
        .def("guide_cells", [](const Renderer& self, const Floats& depth, const cmpg::PassOptions& pass) -> std::optional<Array> {
            const cmpg::Image image = toImage(depth);
            std::optional<cmpg::Image> cells = released([&] { return self.library->guideCells(image, pass); });
            return cells ? std::optional(toArray(std::move(*cells))) : std::nullopt;
        }, "depth"_a, "options"_a)
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
}
