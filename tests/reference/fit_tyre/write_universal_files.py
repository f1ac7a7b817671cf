"""Writes the universal files of this folder: pip install pyuff==2.5.8, then python write_universal_files.py."""

import os

import numpy as np
import pyuff

HERE = os.path.dirname(os.path.abspath(__file__))
STEP = 25.0
EVEN = STEP * np.arange(40)
UNEVEN = np.round(np.geomspace(20.0, 1500.0, 40), 2)


def mobility(frequency):
    """Oscillator: 1e5 N/m, 0.1 kg, 20 N s/m, on a base that gives way by 1 mm/(N s)."""
    s = 2j * np.pi * frequency
    with np.errstate(divide="ignore", invalid="ignore"):
        return 1 / (1e5 / s + 20 + 0.1 * s) + 1e-3


def function(x, y, kind, units="NONE", node=(12, 12), direction=(3, 3), binary=0, function_type=4, double=False, even=True):
    """A dataset 58; kind is the numerator's specific data type, over a force."""
    if not double:
        y = y.astype(np.complex64 if np.iscomplexobj(y) else np.float32)
    complex_values = np.iscomplexobj(y)
    data_type = (6 if double else 5) if complex_values else (4 if double else 2)
    return dict(
        type=58, binary=binary, id1="synthetic oscillator", id2="NONE", id3="NONE", id4="NONE", id5="NONE",
        func_type=function_type, ver_num=0, load_case_id=0, rsp_ent_name="NONE", rsp_node=node[0],
        rsp_dir=direction[0], ref_ent_name="NONE", ref_node=node[1], ref_dir=direction[1],
        ord_data_type=data_type, num_pts=len(x), abscissa_spacing=int(even), abscissa_min=x[0] if even else 0.0,
        abscissa_inc=STEP if even else 0.0, z_axis_value=0.0,
        abscissa_spec_data_type=18 if function_type != 1 else 17, abscissa_len_unit_exp=0, abscissa_force_unit_exp=0,
        abscissa_temp_unit_exp=0, abscissa_axis_lab="Frequency", abscissa_axis_units_lab="Hz",
        ordinate_spec_data_type=kind, ordinate_len_unit_exp=0, ordinate_force_unit_exp=0, ordinate_temp_unit_exp=0,
        ordinate_axis_lab="Response", ordinate_axis_units_lab=units,
        orddenom_spec_data_type=13, orddenom_len_unit_exp=0, orddenom_force_unit_exp=0, orddenom_temp_unit_exp=0,
        orddenom_axis_lab="Force", orddenom_axis_units_lab="NONE",
        z_axis_spec_data_type=0, z_axis_len_unit_exp=0, z_axis_force_unit_exp=0, z_axis_temp_unit_exp=0,
        z_axis_axis_lab="NONE", z_axis_axis_units_lab="NONE", x=x, data=y,
    )


def write(name, sets):
    path = os.path.join(HERE, name)
    if os.path.exists(path):
        os.remove(path)
    pyuff.UFF(path).write_sets(sets, "overwrite", force_double=False)


header = dict(type=151, model_name="NONE", description="NONE", db_app="NONE", date_db_created="01-Jan-26",
              time_db_created="00:00:00", version_db1=0, version_db2=0, file_type=0,
              date_db_saved="01-Jan-26", time_db_saved="00:00:00", program="NONE",
              date_db_written="01-Jan-26", time_db_written="00:00:00")
nodes = dict(type=15, node_nums=[12.0], def_cs=[0.0], disp_cs=[0.0], color=[0.0], x=[0.0], y=[0.0], z=[0.0])


def units(length, force, code=9):
    return dict(type=164, units_code=code, units_description="units", temp_mode=1, length=length, force=force,
                temp=1.0, temp_offset=273.15)


accelerance = np.nan_to_num(2j * np.pi * EVEN * mobility(EVEN))
receptance = np.zeros(len(EVEN), complex)
receptance[1:] = mobility(EVEN[1:]) / (2j * np.pi * EVEN[1:])
si = units(1.0, 1.0, 1)

write("accelerance_text.uff", [header, si, nodes, function(EVEN, accelerance, 12, "m/s^2")])
write("accelerance_binary.uff", [
    header, si, nodes,
    function(EVEN, np.ones(40), 0, function_type=1, binary=1),
    function(EVEN, accelerance, 12, "m/s^2", binary=1),
    function(EVEN, 0.5 * accelerance, 12, "m/s^2", node=(13, 12), binary=1),
    function(EVEN, np.ones(40), 0, function_type=6, binary=1),
])
write("mobility_double_uneven.uff", [function(UNEVEN, mobility(UNEVEN), 11, double=True, even=False)])
write("receptance_mm_kn.uff", [header, units(1e3, 1e-3), function(EVEN, 1e6 * receptance, 8, "mm", double=True, binary=1)])
write("two_points_opposite.uff", [
    si,
    function(EVEN, accelerance, 12, "m/s^2"),
    function(EVEN, -accelerance, 12, "m/s^2", node=(14, 14), direction=(-3, 3)),
])
