// Image files for the tests, written by the libraries and not by our own writers.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <cstdint>
#include <filesystem>
#include <stb/stb_image_write.h>
#include <string>
#include <vector>

namespace cmpg::test {

inline void savePng(const std::filesystem::path& file, int width, int height, int channels, const std::vector<std::uint8_t>& codes) {
    std::filesystem::create_directories(file.parent_path());
    stbi_write_png(file.c_str(), width, height, channels, codes.data(), width * channels);
}

// Float EXR with one-letter channels, interleaved in `values` in the order of `channels`: the pixels of `data`, of a picture that is `display`.
inline void saveExr(const std::filesystem::path& file, const Imath::Box2i& display, const Imath::Box2i& data, const std::string& channels,
                    std::vector<float> values) {
    Imf::Header header(display, data);
    Imf::FrameBuffer frame;
    const std::size_t step = channels.size() * sizeof(float), width = std::size_t(data.max.x - data.min.x) + 1;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const std::string name(1, channels[c]);
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        frame.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data() + c, data, step, step * width));
    }
    Imf::OutputFile output(file.c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(data.max.y - data.min.y + 1);
}

inline void saveExr(const std::filesystem::path& file, int width, int height, const std::string& channels, const std::vector<float>& values) {
    const Imath::Box2i all({0, 0}, {width - 1, height - 1});
    saveExr(file, all, all, channels, values);
}

} // namespace cmpg::test
