// A picture to draw into: images, text, lines. Text and lines are drawn by Cairo, smooth.
#pragma once

#include "scene/image.h"

#include <array>
#include <string_view>

namespace cmpg {

using Color = std::array<float, 3>;               // linear RGB
Color displayColor(int red, int green, int blue); // from 8-bit sRGB
constexpr Color kBlack = {0, 0, 0}, kWhite = {1, 1, 1};

// Linear RGB, encoded when written. Whatever lies outside is cut off.
class Canvas {
  public:
    Canvas(int width, int height, Color background = kWhite);

    int width() const { return image_.width; }
    int height() const { return image_.height; }
    const Image& image() const { return image_; }

    void set(int x, int y, Color color);
    void rectangle(int x, int y, int width, int height, Color color);
    void line(double x0, double y0, double x1, double y1, Color color, int thickness = 1);
    // Top left corner of the capitals, which are 7 `zoom` pixels high. UTF-8.
    void text(int x, int y, std::string_view text, Color color = kBlack, int zoom = 1);
    // `image` has 3 channels. Its pixels become blocks, or are averaged, to fit into width x height with their aspect kept: at its
    // top, centred across.
    void picture(int x, int y, int width, int height, const Image& image);

    static int textWidth(std::string_view text, int zoom = 1);
    static int textHeight(int zoom = 1);

  private:
    // Mixes the colour in by how much of each pixel draw(context) covers; within a box.
    template <class Draw> void blend(int x, int y, int width, int height, Color color, Draw&& draw);

    Image image_;
};

} // namespace cmpg
