"""Parameters of the visual place cells: one block, the paper's Table I as presets."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, structs

from fpnav.params import Count, NotNegative, Params, Positive, Share


class PlacecellParams(Params, frozen=True):
    """Block ``placecell``; pixels are those of a panorama ``width`` columns around.

    Seeing (systems.md 2.3)
    width : columns of 360 degrees; other images are resampled to this resolution
    deriche : alpha of the gradient in 1/px
    dog_sigma1, dog_sigma2 : centre and surround of the filter in px
    dog_size, dog_size_is_half : size l; the mask is 2 l - 1 wide, or l
    focus, focus_image : most focus points of a panorama, and of one forward image
    focus_spacing : least distance of two, as a share of the radius
    focus_margin : distance to the image's border, as a share of the radius
    radius, patch_columns, patch_rows : disc around a focus point, resampled to log radius x angle
    patch_source, patch_norm : what the views show; meanstd takes brightness and contrast out
    drop_hidden : no view touches columns of one grey from top to bottom: something hangs there
    images, streaming : forward images that make a panorama while the camera pans; a signature
        with every image (each with the newest ones) rather than with every full panorama

    Landmarks and places (2.1, 2.5, 2.6)
    rt : recognition threshold RT
    interpretations : landmarks kept per view; 1 = strict competition
    rho_az, rho_el : lateral diffusion as a fraction of pi; 0 = infinite, the angle is ignored
    diffusion : shape of g
    azimuth_bins : preferred azimuths of the neurons; 0 = continuous
    stm, qmax : a triplet whose activity rises lasts ``qmax`` panoramas (images where streaming),
        0 = the present one; literal compares as the paper writes it, window keeps the largest value
        of the last ``qmax``
    rho_l : share of a place's triplets that must be seen (eq. 4); 1 = eq. 3
    heading : azimuth from the compass, from odometry (runs must begin alike), from recognised
        landmarks (visual), or searched for in steps of ``search_deg``, as it is where frames have
        no heading
    reuse, reuse_vigilance : a view recognised at this level recruits no landmark
    vigilance, refractory : a new place where the cell that founded the present one is less active,
        not within this many panoramas of the last
    spacing_m : or a new place every so many metres; 0 = by vigilance
    cells : place cells a place may hold, one learned where the others are less active than
        ``cell_vigilance``; 0 = no bound
    weights : what a triplet counts: 1 each (equal), or how often it was seen again (repeatability)
    budget : triplets kept per place when the map is built; 0 = all
    step_m, step_heading_deg : thinning of frames
    """

    width: Annotated[int, Meta(ge=32, le=8192)] = 720
    deriche: Annotated[float, Meta(ge=0.2, le=10.0)] = 0.8
    dog_sigma1: Positive = 1.5
    dog_sigma2: Positive = 2.0
    dog_size: Annotated[int, Meta(ge=3, le=101)] = 8
    dog_size_is_half: bool = True
    focus: Annotated[int, Meta(ge=1, le=1000)] = 30
    focus_image: Annotated[int, Meta(ge=1, le=1000)] = 6
    focus_spacing: NotNegative = 0.5
    focus_margin: NotNegative = 1.0
    radius: Annotated[float, Meta(ge=2.0, le=1000.0)] = 20.0
    patch_columns: Annotated[int, Meta(ge=4, le=64)] = 16
    patch_rows: Annotated[int, Meta(ge=4, le=64)] = 16
    patch_source: Literal["grey", "gradient"] = "grey"
    patch_norm: Literal["none", "meanstd"] = "none"
    drop_hidden: bool = False
    images: Count = 1
    streaming: bool = False

    rt: Annotated[float, Meta(ge=0.0, lt=1.0)] = 0.8
    interpretations: Count = 4
    rho_az: NotNegative = 0.33
    rho_el: NotNegative = 0.0
    diffusion: Literal["linear", "gaussian"] = "linear"
    azimuth_bins: Annotated[int, Meta(ge=0)] = 0
    stm: Literal["counter", "literal", "window"] = "counter"
    qmax: Annotated[int, Meta(ge=0)] = 0
    rho_l: Annotated[float, Meta(gt=0.0, le=1.0)] = 1.0
    heading: Literal["compass", "odometry", "visual", "search"] = "compass"
    search_deg: Annotated[float, Meta(gt=0.0, le=90.0)] = 5.0
    reuse: bool = False
    reuse_vigilance: Share = 0.9
    vigilance: Share = 0.5
    refractory: Annotated[int, Meta(ge=0)] = 3
    spacing_m: NotNegative = 0.0
    cells: Annotated[int, Meta(ge=0)] = 1
    cell_vigilance: Share = 1.0
    weights: Literal["equal", "repeatability"] = "equal"
    budget: Annotated[int, Meta(ge=0)] = 0
    step_m: NotNegative = 0.0
    step_heading_deg: NotNegative = 0.0

    @property
    def pixels(self) -> int:
        """Pixels of one local view."""
        return self.patch_columns * self.patch_rows


_FIG3B = PlacecellParams(
    width=1500,
    deriche=0.8,
    dog_sigma1=3.0,
    dog_sigma2=4.0,
    dog_size=15,
    focus=120,
    patch_columns=32,
    patch_rows=32,
    radius=40.0,
    rt=0.8,
    interpretations=4,
    rho_az=0.33,
    rho_el=0.0,
    diffusion="linear",
    qmax=0,
    rho_l=1.0,
)
_FIG4C = structs.replace(_FIG3B, qmax=4, vigilance=0.35)
_FIG7B = PlacecellParams(
    width=750,
    deriche=1.0,
    dog_sigma1=1.0,
    dog_sigma2=2.0,
    dog_size=5,
    patch_columns=16,
    patch_rows=16,
    radius=20.0,
    rt=0.8,
    interpretations=4,
    rho_az=0.2,
    rho_el=1.0,
    diffusion="gaussian",
    qmax=4,
    rho_l=0.25,
    vigilance=0.35,
)
_FIG8 = PlacecellParams(
    width=1045,  # 192 px over 60 degrees
    focus_image=20,
    deriche=0.8,
    dog_sigma1=2.0,
    dog_sigma2=4.0,
    dog_size=10,
    patch_columns=16,
    patch_rows=16,
    radius=35.0,
    images=9,
    streaming=True,
    rt=0.8,
    interpretations=3,
    rho_az=0.33,
    rho_el=0.33,
    diffusion="gaussian",
    qmax=18,
    rho_l=0.33,
    vigilance=0.35,
)

PRESETS = {
    "fig3b": _FIG3B,
    "fig4c": _FIG4C,
    "paper": _FIG4C,
    "fig7b": _FIG7B,
    "fig8": _FIG8,
    "default": PlacecellParams(
        width=480,
        dog_sigma1=1.5,
        dog_sigma2=3.0,
        dog_size=8,
        focus=60,
        focus_image=30,
        focus_spacing=0.25,
        focus_margin=0.3,
        radius=22.0,
        patch_norm="meanstd",
        rt=0.85,
        interpretations=10,
        rho_az=0.06,
        rho_el=0.1,
        diffusion="gaussian",
        rho_l=0.3,
        heading="search",
        vigilance=0.3,
        cells=0,
    ),
}
"""The columns of Table I; where the paper is silent, the values of systems.md 2.10."""

_SEEING = frozenset(
    {
        "width",
        "deriche",
        "dog_sigma1",
        "dog_sigma2",
        "dog_size",
        "dog_size_is_half",
        "focus",
        "focus_image",
        "focus_spacing",
        "focus_margin",
        "radius",
        "patch_columns",
        "patch_rows",
        "patch_source",
        "patch_norm",
        "drop_hidden",
        "images",
        "streaming",
        "step_m",
        "step_heading_deg",
    }
)

LATE = frozenset(PlacecellParams.__struct_fields__) - _SEEING
"""Parameters that act on local views, not in making them."""
