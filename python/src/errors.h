// Errors of the library as exceptions of the package.
#pragma once

#include <cmpg/error.h>

#include <nanobind/nanobind.h>

#include <algorithm>

inline const char* kindName(cmpg::ErrorKind kind) {
    switch (kind) {
    case cmpg::ErrorKind::Usage:
        return "UsageError";
    case cmpg::ErrorKind::Input:
        return "InputError";
    case cmpg::ErrorKind::Device:
        return "DeviceError";
    case cmpg::ErrorKind::Numerical:
        return "NumericalError";
    case cmpg::ErrorKind::Output:
        break;
    }
    return "OutputError";
}

inline void translate(const std::exception_ptr& thrown, void*) {
    namespace nb = nanobind;
    try {
        std::rethrow_exception(thrown);
    } catch (const cmpg::Error& error) {
        std::vector<std::string> options = error.options; // as keyword arguments
        for (std::string& option : options)
            if (option == "inspect")
                option = "Scene.parameters, Scene.cameras";
            else
                std::replace(option.begin(), option.end(), '-', '_');
        // File names need not be UTF-8. Python has them so, too.
        const auto text = [](const std::string& s) {
            PyObject* const decoded = PyUnicode_DecodeUTF8(s.data(), Py_ssize_t(s.size()), "surrogateescape");
            if (!decoded)
                throw nb::python_error();
            return nb::steal(decoded);
        };
        nb::list names;
        for (const std::string& option : options)
            names.append(text(option));
        const nb::object type = nb::module_::import_("cmpg._errors").attr(kindName(error.kind));
        const nb::object made = type(text(error.what()), text(error.cause), text(error.remedy), names);
        PyErr_SetObject(type.ptr(), made.ptr());
    }
}
