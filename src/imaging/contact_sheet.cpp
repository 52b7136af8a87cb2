// One picture that tells how an optimisation went: its views, its parameters at start and end, and the loss.
#include "imaging/contact_sheet.h"

#include "imaging/exposure.h"
#include "imaging/fitted_image.h"
#include "imaging/loss_curve.h"
#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>

namespace cmpg {
namespace {

constexpr int kPanel = 256, kMargin = 12, kTitle = 30, kCaption = 18, kColumns = 4;
constexpr int kStride = kPanel + kMargin;
constexpr int kTextRow = 22;
constexpr double kTextSize = 20;
constexpr std::size_t kMostConstants = 16;

int column(int index) { return kMargin + index * kStride; }

// Three channels in [0,1], of values times a factor plus an offset.
Image shown(const Image& image, float factor, float offset = 0) {
    Image result(image.width, image.height, 3);
    for (std::size_t p = 0; p < image.pixels(); ++p)
        for (int c = 0; c < 3; ++c) {
            const float v = image.values[p * image.channels + std::min(c, image.channels - 1)] * factor + offset;
            result.values[3 * p + c] = std::isfinite(v) ? std::clamp(v, 0.f, 1.f) : 0.f;
        }
    return result;
}

// Of the pictures of a row.
int panelHeight(std::initializer_list<const Image*> images) {
    int height = 1;
    for (const Image* image : images)
        if (!image->values.empty())
            height = std::max(height, fittedSize(*image, kPanel, kPanel).height);
    return height;
}

int panelHeight(const ContactSheet::ViewRow& row) { return panelHeight({&row.target, &row.initial, &row.recovered}); }
int panelHeight(const ContactSheet::ParameterRow& row) { return panelHeight({&row.start, &row.end, &row.gradient}); }

int rowHeight(int panel) { return kCaption + panel + kSignedLegendHeight + kMargin; }

// As many characters as fit the width of a panel.
std::string fitted(std::string text) {
    while (Drawing::textWidth(text) > kPanel)
        text.pop_back();
    return text;
}

void drawPicture(Drawing& drawing, int x, int y, const std::string& caption, const Image& picture) {
    drawing.label(x, y, fitted(caption));
    if (!picture.values.empty())
        drawing.image(x, y + kCaption, kPanel, kPanel, picture);
}

// `panel`: the height of the row's pictures.
void drawSigned(Drawing& drawing, int x, int y, int panel, const std::string& caption, const Image& image) {
    const Image values = channelMean(image);
    const double scale = signedScale(values);
    drawPicture(drawing, x, y, caption, colorSigned(values, scale));
    drawSignedLegend(drawing, x, y + kCaption + panel + 4, kPanel, scale);
}

Image difference(const Image& a, const Image& b) {
    Image result = a;
    for (std::size_t i = 0; i < result.values.size() && i < b.values.size(); ++i)
        result.values[i] -= b.values[i];
    return result;
}

// Rows return their heights.
int drawView(Drawing& drawing, int y, const ContactSheet::ViewRow& view, float factor) {
    const int panel = panelHeight(view);
    const std::string suffix = view.name.empty() ? "" : ", " + view.name;
    drawPicture(drawing, column(0), y, "target" + suffix, shown(view.target, factor));
    drawPicture(drawing, column(1), y, "initial", shown(view.initial, factor));
    drawPicture(drawing, column(2), y, "recovered", shown(view.recovered, factor));
    if (!view.difference.values.empty())
        drawSigned(drawing, column(3), y, panel, "recovered - target, mean of the channels", view.difference);
    return rowHeight(panel);
}

// Normals are shown as they are kept in files; light, which has no upper bound, with one exposure at both ends.
int drawTexture(Drawing& drawing, int y, const ContactSheet::ParameterRow& row) {
    const int panel = panelHeight(row);
    const bool normal = row.kind == SlotKind::Normal, light = emitsLight(row.kind);
    const float factor = normal ? 0.5f : light ? exposureFor({&row.start, &row.end}) : 1.f, offset = normal ? 0.5f : 0.f;
    drawPicture(drawing, column(0), y, row.name + ", start", shown(row.start, factor, offset));
    drawPicture(drawing, column(1), y, row.name + ", end", shown(row.end, factor, offset));
    drawSigned(drawing, column(2), y, panel, "change, mean of the channels", difference(row.end, row.start));
    drawSigned(drawing, column(3), y, panel, "gradient of the last step, mean of the channels", row.gradient);
    return rowHeight(panel);
}

std::string numbers(const Image& image, int digits) {
    std::string text;
    char number[32];
    for (const float v : image.values) {
        std::snprintf(number, sizeof number, text.empty() ? "%.*g" : " %.*g", digits, double(v));
        text += number;
    }
    return text;
}

void drawConstants(Drawing& drawing, int y, std::span<const ContactSheet::ParameterRow* const> rows, std::size_t all) {
    const auto line = [&](const std::string& name, const std::string& start, const std::string& end, const std::string& gradient) {
        const std::string cells[kColumns] = {name, start, end, gradient};
        for (int i = 0; i < kColumns; ++i) {
            const double shrunk = kTextSize * (kPanel - 1) / std::max<double>(Drawing::textWidth(cells[i], kTextSize), kPanel - 1); // what is long stays whole
            drawing.label(column(i), y, cells[i], "#000000", std::max(shrunk, double(Drawing::kLabelSize)));
        }
        y += kTextRow;
    };
    line("constant", "start", "end", "gradient");
    for (const ContactSheet::ParameterRow* row : rows)
        line(row->name, numbers(row->start, 4), numbers(row->end, 4), numbers(row->gradient, 2)); // noise has no more digits
    if (all > rows.size())
        line("and " + std::to_string(all - rows.size()) + " more", "", "", "");
}

} // namespace

Image ContactSheet::compose() const {
    std::vector<const ParameterRow*> textures, constants;
    for (const ParameterRow& row : parameters)
        (row.end.pixels() > 1 ? textures : constants).push_back(&row);
    const std::size_t allConstants = constants.size();
    textures.resize(std::min(textures.size(), kMostRows));
    constants.resize(std::min(constants.size(), kMostConstants));
    const std::span someViews(views.data(), std::min(views.size(), kMostRows));
    int pictures = 0;
    for (const ViewRow& row : someViews)
        pictures += rowHeight(panelHeight(row));
    for (const ParameterRow* row : textures)
        pictures += rowHeight(panelHeight(*row));
    const int text = constants.empty() ? 0 : kTextRow * int(1 + constants.size() + (allConstants > constants.size())) + kMargin;

    // The loss has a column of its own, as high as it is wide.
    Drawing drawing(Drawing::Target::Picture, kMargin + (kColumns + 1) * kStride, kTitle + std::max(pictures + text, rowHeight(kPanel)));
    drawing.label(kMargin, kMargin / 2, title, "#000000", kTextSize);
    std::vector<const Image*> targets;
    for (const ViewRow& row : views)
        targets.push_back(&row.target);
    const float factor = exposureFor(targets);
    int y = kTitle;
    for (const ViewRow& row : someViews)
        y += drawView(drawing, y, row, factor);
    for (const ParameterRow* row : textures)
        y += drawTexture(drawing, y, *row);
    if (!constants.empty())
        drawConstants(drawing, y, constants, allConstants);
    drawing.label(column(kColumns), kTitle, lossError.empty() ? "loss" : "loss, band: one standard error");
    drawLossCurve(drawing, column(kColumns), kTitle + kCaption, kPanel, kPanel, loss, lossError);
    return drawing.picture();
}

} // namespace cmpg
