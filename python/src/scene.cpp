// Pictures, devices and scenes of the module.
#include "handles.h"
#include "ranks.h"

void bindScene(nb::module_& m) {
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
        .def("__init__", [](Device* self, const std::string& select, nb::object ranks) {
            const std::shared_ptr<cmpg::Communicator> communicator = communicatorOf(std::move(ranks));
            new (self) Device(released([&] { return cmpg::Device(select, communicator); }));
        }, "select"_a, "ranks"_a.none())
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
                            const std::map<std::string, std::string>& define, const std::optional<std::string>& filter) {
            new (self) cmpg::Scene(released([&] {
                cmpg::SceneOptions options{environment, rotation, define};
                if (filter)
                    options.filter = cmpg::ReconstructionFilter::parse(*filter);
                return cmpg::Scene::load(file, options);
            }));
        }, "file"_a, "environment"_a, "environment_rotation"_a, "define"_a, "filter"_a.none())
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
        .def("pick", [](const cmpg::Scene& self, float x, float y, const std::string& camera, int width, int height) -> nb::object {
            const std::optional<cmpg::SurfacePoint> point = released([&] {
                const auto [w, h] = self.imageSize(camera, width, height); // throws where there is no such camera
                const std::vector<cmpg::CameraInfo> cameras = self.cameras();
                const auto named = std::find_if(cameras.begin(), cameras.end(), [&](const cmpg::CameraInfo& c) { return c.name == camera; });
                return self.pick(named == cameras.end() ? cameras.front() : *named, w, h, x, y);
            });
            if (!point)
                return nb::none();
            const auto tuple = [](const std::array<float, 3>& v) { return nb::make_tuple(v[0], v[1], v[2]); };
            return nb::make_tuple(tuple(point->position), tuple(point->normal), point->distance, point->material);
        }, "x"_a, "y"_a, "camera"_a, "width"_a, "height"_a)
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
        .def("export", [](const cmpg::Scene& scene, const std::filesystem::path& folder) { scene.exportTo(folder); }, "folder"_a, nb::call_guard<nb::gil_scoped_release>());
}
