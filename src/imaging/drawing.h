// Plots and sheets of pictures, drawn by Cairo: the same calls make an SVG or a picture.
#pragma once

#include "scene/image.h"

#include <memory>
#include <span>
#include <string>
#include <utility>

namespace cmpg {

// Lengths are pixels of a picture, y downwards. Colours are "#rrggbb".
class Drawing {
  public:
    enum class Target { Svg, Picture };
    enum class Anchor { Start, Middle, End };
    using Point = std::pair<double, double>;
    static constexpr double kLabelSize = 10;

    // White. `title`: what an SVG says it shows; letters in it are outlines.
    // Throws Error(Output) where a picture is larger than Cairo draws: 32767 pixels.
    Drawing(Target target, double width, double height, const std::string& title = {});
    ~Drawing();

    void line(double x0, double y0, double x1, double y1, const std::string& color, double width = 1, bool dashed = false);
    void path(std::span<const Point> points, const std::string& color, double width);
    // Fills what lies within a polygon and a box.
    void area(std::span<const Point> points, const std::string& color, double x0, double y0, double x1, double y1);
    void box(double x0, double y0, double x1, double y1, const std::string& color); // its outline
    void circle(double x, double y, double radius, const std::string& color, bool filled = true);
    // `baseline`: of the letters. UTF-8. What is not is drawn as '?'.
    void text(double x, double baseline, const std::string& text, Anchor anchor = Anchor::Start, const std::string& color = "#000000", double size = 12);
    // `top`: of the capitals.
    void label(double x, double top, const std::string& text, const std::string& color = "#000000", double size = kLabelSize);
    void upwards(double baseline, double middle, const std::string& text); // from bottom to top
    // `image` has 3 channels, linear. Fitted into width x height (fittedImage()): at its top, centred across.
    void image(int x, int y, int width, int height, const Image& image);

    static int textWidth(const std::string& text, double size = kLabelSize);
    static int capitals(double size = kLabelSize); // their height

    std::string svg(); // the file; nothing can be drawn any more
    Image picture();   // linear RGB, of 8 bits in sRGB

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cmpg
