// Guides of the module: at a point, and in a file.
#include "handles.h"

namespace {

std::array<double, 3> toMixture(const std::vector<double>& weights) {
    if (weights.size() != 3)
        throw cmpg::Error(cmpg::ErrorKind::Usage, "a mixture has 3 parts, not " + std::to_string(weights.size()), {},
                          "give the weights of light, and of the positive and the negative terms of its derivatives");
    return {weights[0], weights[1], weights[2]};
}

nb::dict toDict(const cmpg::GuideFigures& f) {
    nb::dict figures;
    figures["lower"] = toTuple(f.lower);
    figures["upper"] = toTuple(f.upper);
    figures["cells"] = f.cells;
    figures["nodes"] = f.nodes;
    figures["most_nodes"] = f.mostNodes;
    figures["spatial_depth"] = f.spatialDepth;
    figures["quad_depth"] = f.quadDepth;
    figures["mean_spatial_depth"] = f.meanSpatialDepth;
    figures["mean_quad_depth"] = f.meanQuadDepth;
    figures["records"] = f.records;
    figures["mass"] = toTuple(f.mass);
    figures["without_records"] = f.withoutRecords;
    figures["without_derivative"] = f.withoutDerivative;
    figures["most_records"] = f.mostRecords;
    figures["updates"] = f.updates;
    figures["forgetting"] = f.forgetting;
    figures["parameters"] = f.parameters;
    figures["methods"] = toList(f.methods);
    figures["reference"] = f.reference;
    return figures;
}

// One row a cell.
nb::ndarray<nb::numpy, double> toRows(const std::vector<cmpg::GuideCellFigures>& cells, std::size_t columns, auto&& row) {
    auto* kept = new std::vector<double>();
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
    for (const cmpg::GuideCellFigures& cell : cells)
        for (const double value : row(cell))
            kept->push_back(value);
    return nb::ndarray<nb::numpy, double>(kept->data(), {cells.size(), columns}, owner);
}

nb::dict toDict(const std::vector<cmpg::GuideCellFigures>& cells) {
    using Cell = cmpg::GuideCellFigures;
    nb::dict columns;
    columns["lower"] = toRows(cells, 3, [](const Cell& c) { return c.lower; });
    columns["upper"] = toRows(cells, 3, [](const Cell& c) { return c.upper; });
    columns["means"] = toRows(cells, 3, [](const Cell& c) { return c.means; });
    const auto one = [&](const char* name, auto member) {
        columns[name] = toRows(cells, 1, [&](const Cell& c) { return std::array{double(c.*member)}; });
    };
    one("depth", &Cell::depth);
    one("quad_depth", &Cell::quadDepth);
    one("nodes", &Cell::nodes);
    one("records", &Cell::records);
    one("reflected", &Cell::reflected);
    one("derivative", &Cell::derivative);
    return columns;
}

} // namespace

void bindGuide(nb::module_& m) {
    nb::class_<cmpg::GuidePoint>(m, "GuidePoint")
        .def_ro("cell", &cmpg::GuidePoint::cell)
        .def_ro("cells", &cmpg::GuidePoint::cells)
        .def_ro("records", &cmpg::GuidePoint::records)
        .def_ro("weight", &cmpg::GuidePoint::weight)
        .def_prop_ro("means", [](const cmpg::GuidePoint& self) { return toTuple(self.means); })
        .def_prop_ro("weights", [](const cmpg::GuidePoint& self) { return toTuple(self.weights); })
        .def_ro("light_share", &cmpg::GuidePoint::lightShare)
        .def_ro("guide_share", &cmpg::GuidePoint::guideShare)
        .def("density", [](const cmpg::GuidePoint& self, const std::vector<double>& mixture, int edge) {
            return toArray(released([&] { return self.density(toMixture(mixture), edge); }));
        }, "mixture"_a, "edge"_a);

    nb::class_<cmpg::Guide>(m, "Guide")
        .def_static("load", [](const std::filesystem::path& file) { return released([&] { return cmpg::Guide::load(file); }); }, "file"_a)
        .def("figures", [](const cmpg::Guide& self) { return toDict(self.figures()); })
        .def("cells", [](const cmpg::Guide& self) { return toDict(self.cells()); })
        .def("fault", [](const cmpg::Guide& self) { return released([&] { return self.fault(); }); })
        .def("density", [](const cmpg::Guide& self, std::uint32_t cell, const std::vector<double>& mixture, int edge) {
            return toArray(released([&] { return self.density(cell, toMixture(mixture), edge); }));
        }, "cell"_a, "mixture"_a, "edge"_a);
}
