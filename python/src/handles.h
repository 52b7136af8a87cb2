// What all parts of the module share: arrays in place of vectors, handles of the library, the lock of the interpreter.
#pragma once

#include <cmpg/cmpg.h>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace nb = nanobind;
using namespace nb::literals;

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
using Film = cmpg::Film; // no device has a part of it

// An array that takes over the values.
inline Array toArray(std::vector<float> values, int height, int width, int channels) {
    if (values.size() != std::size_t(height) * std::size_t(width) * std::size_t(channels)) // numpy would read what lies behind them
        throw cmpg::Error(cmpg::ErrorKind::Usage,
                          std::to_string(values.size()) + " values do not fill " + std::to_string(height) + " x " + std::to_string(width) + " x " +
                              std::to_string(channels),
                          "the parameter was given another size meanwhile", "ask again");
    auto* kept = new std::vector<float>(std::move(values));
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<float>*>(p); });
    return Array(kept->data(), {std::size_t(height), std::size_t(width), std::size_t(channels)}, owner);
}
inline Array toArray(const std::vector<double>& values, int height, int width, int channels) {
    return toArray(std::vector<float>(values.begin(), values.end()), height, width, channels);
}
inline Array toArray(cmpg::Image image) { return toArray(std::move(image.values), image.height, image.width, image.channels); }
template <class T> Array toArray(std::vector<T> values, const cmpg::ParameterInfo& info) {
    return toArray(std::move(values), info.height, info.width, info.channels);
}

// By name. `guided`: also what a guide does.
nb::dict toArrays(cmpg::Layers layers, bool guided);
nb::list toList(const std::vector<cmpg::MethodFigures>& figures);

// Where in the scene.
inline std::array<float, 3> toPoint(const std::vector<float>& place) {
    if (place.size() != 3)
        throw cmpg::Error(cmpg::ErrorKind::Usage, "a point has 3 coordinates, not " + std::to_string(place.size()), {}, "give x, y and z");
    return {place[0], place[1], place[2]};
}
inline nb::tuple toTuple(const std::array<float, 3>& v) { return nb::make_tuple(v[0], v[1], v[2]); }
inline nb::tuple toTuple(const std::array<double, 3>& v) { return nb::make_tuple(v[0], v[1], v[2]); }

inline cmpg::Image toImage(const Floats& array) {
    if (array.ndim() != 3 || (array.shape(2) != 1 && array.shape(2) != 3))
        throw cmpg::Error(cmpg::ErrorKind::Usage, "an image is an array of (height, width, 3)", {}, "reshape it");
    cmpg::Image image(int(array.shape(1)), int(array.shape(0)), int(array.shape(2)));
    std::copy_n(array.data(), array.size(), image.values.begin());
    return image;
}
inline std::vector<float> toVector(const Floats& array) { return {array.data(), array.data() + array.size()}; }

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

// Ctrl-C ends a pass.
inline void endOnSignals() {
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0)
        throw nb::python_error();
}

// A Python function that the library keeps: let go with the lock of the interpreter held, as the library does not.
inline std::shared_ptr<nb::object> kept(nb::object call) {
    return {new nb::object(std::move(call)), [](nb::object* p) {
                const nb::gil_scoped_acquire gil;
                delete p;
            }};
}

// For Renderer and Recovery: ends a pass on signals, and calls what else was asked for.
inline std::function<void()> onSubmission(nb::object call) {
    if (call.is_none())
        return endOnSignals;
    return [call = kept(std::move(call))] {
        endOnSignals();
        const nb::gil_scoped_acquire gil;
        (*call)();
    };
}

template <class Work> auto released(Work&& work) {
    nb::gil_scoped_release unlocked;
    return work();
}

// The parts of the module.
void bindScene(nb::module_& m);    // pictures, devices, scenes
void bindRenderer(nb::module_& m); // options of passes, what they report, renderers
void bindGuide(nb::module_& m);    // what was learned, at a point and in a file
void bindRecovery(nb::module_& m); // targets, steps, recoveries
