// Pictures, devices and scenes of the module.
#include "handles.h"
#include "ranks.h"

namespace {

// The first where `name` is empty.
cmpg::CameraInfo cameraOf(const cmpg::Scene& scene, const std::string& name) {
    scene.imageSize(name); // throws where there is no such camera
    const std::vector<cmpg::CameraInfo> cameras = scene.cameras();
    const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const cmpg::CameraInfo& c) { return c.name == name; });
    return found == cameras.end() ? cameras.front() : *found;
}

void bindCamera(nb::module_& m) {
    nb::class_<cmpg::CameraInfo>(m, "CameraInfo")
        .def("__init__", [](cmpg::CameraInfo* self, const std::string& name, const std::vector<float>& columns, bool orthographic, float yfov, float ymag,
                            const std::optional<float>& aspect) {
            if (columns.size() != 16)
                throw cmpg::Error(cmpg::ErrorKind::Usage, "the pose of a camera is a matrix of (4, 4)", {}, "give camera to world", {"camera"});
            new (self) cmpg::CameraInfo{.name = name, .aspect = aspect, .orthographic = orthographic, .yfov = yfov, .ymag = ymag};
            std::copy(columns.begin(), columns.end(), self->toWorld.begin());
        }, "name"_a, "columns"_a, "orthographic"_a, "yfov"_a, "ymag"_a, "aspect"_a.none())
        .def_ro("name", &cmpg::CameraInfo::name)
        .def_ro("aspect", &cmpg::CameraInfo::aspect)
        .def_prop_ro("columns", [](const cmpg::CameraInfo& self) { return std::vector<float>(self.toWorld.begin(), self.toWorld.end()); })
        .def_ro("orthographic", &cmpg::CameraInfo::orthographic)
        .def_ro("yfov", &cmpg::CameraInfo::yfov)
        .def_ro("ymag", &cmpg::CameraInfo::ymag);
}

} // namespace

void bindScene(nb::module_& m) {
    bindCamera(m);
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
        .def("camera", [](const cmpg::Scene& self, const std::string& name) { return released([&] { return cameraOf(self, name); }); }, "name"_a)
        .def("pick", [](const cmpg::Scene& self, float x, float y, const std::string& camera, const std::optional<cmpg::CameraInfo>& moved, int width,
                        int height) -> nb::object {
            const std::optional<cmpg::SurfacePoint> point = released([&] { return self.pick(moved ? *moved : cameraOf(self, camera), width, height, x, y); });
            if (!point)
                return nb::none();
            return nb::make_tuple(toTuple(point->position), toTuple(point->normal), point->distance, point->material);
        }, "x"_a, "y"_a, "camera"_a, "moved"_a.none(), "width"_a, "height"_a)
        .def("parameters", [](const cmpg::Scene& self) { return released([&] { return self.parameters(); }); })
        .def("parameter", [](const cmpg::Scene& self, const std::string& name) { return released([&] { return self.parameter(name); }); }, "name"_a)
        .def("select", &cmpg::Scene::select, "glob"_a)
        .def("values", [](const cmpg::Scene& self, const std::string& name) {
            cmpg::ParameterInfo info;
            std::vector<float> values = released([&] { return self.values(name, &info); });
            return toArray(std::move(values), info);
        }, "name"_a)
        .def("set", [](cmpg::Scene& self, const std::string& name, const Floats& values) {
            released([&] { self.set(name, std::span(values.data(), values.size())); });
        }, "name"_a, "values"_a)
        .def("resize", [](cmpg::Scene& self, const std::string& name, int width, int height) { released([&] { self.resize(name, width, height); }); }, "name"_a, "width"_a, "height"_a)
        .def("export", [](const cmpg::Scene& scene, const std::filesystem::path& folder) { scene.exportTo(folder); }, "folder"_a, nb::call_guard<nb::gil_scoped_release>());
}
