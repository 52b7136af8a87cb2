// The file of --layers.
#include "imaging/layers_file.h"

namespace cmpg {

void writeLayers(const std::string& file, const Layers& layers, bool guided) {
    std::vector<std::pair<std::string, Image>> named;
    const auto add = [&](const Image& image, std::initializer_list<const char*> names) {
        int channel = 0;
        for (const char* name : names) {
            Image plane(image.width, image.height, 1);
            for (std::size_t p = 0; p < image.pixels(); ++p)
                plane.values[p] = image.values[p * image.channels + channel];
            named.emplace_back(name, std::move(plane));
            ++channel;
        }
    };
    add(layers.normal, {"normal.X", "normal.Y", "normal.Z"});
    add(layers.depth, {"depth.Z"});
    add(layers.albedo, {"albedo.R", "albedo.G", "albedo.B"});
    add(layers.samples, {"samples.Y"});
    if (guided) {
        add(layers.guided, {"guided.Y"});
        add(layers.dead, {"dead.Y"});
        add(layers.cell, {"cell.Y"});
        for (std::size_t d = 0; d < layers.lightShare.size(); ++d)
            named.emplace_back("light_share" + std::to_string(d + 1) + ".Y", layers.lightShare[d]);
    }
    writeExrLayers(file, named);
}

} // namespace cmpg
