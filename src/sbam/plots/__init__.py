"""The figures of the paper and of a plan. Every function returns a matplotlib figure; no window is opened."""

from sbam.plots.base_map import plot_base_map
from sbam.plots.constraints import plot_spatial_relations
from sbam.plots.learning import plot_generalized_changes, plot_keypoints, plot_segmentation
from sbam.plots.planning import plot_comparison, plot_scene_path, plot_trajectory
from sbam.plots.style import save_figure
from sbam.plots.write import write_model_plots, write_plan_plots

__all__ = [
    "plot_base_map",
    "plot_comparison",
    "plot_generalized_changes",
    "plot_keypoints",
    "plot_scene_path",
    "plot_segmentation",
    "plot_spatial_relations",
    "plot_trajectory",
    "save_figure",
    "write_model_plots",
    "write_plan_plots",
]
