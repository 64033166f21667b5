"""Designs are values."""

import copy
import pickle

import numpy as np
import pytest

import modsearch
from modsearch import Design


def test_a_design_is_a_sequence_of_types_with_their_parameters():
    design = Design([("hinge", [0.5, 1.25]), ("link", [0.75])])
    assert len(design) == 2
    assert design.types == ["hinge", "link"]
    np.testing.assert_array_equal(design.parameters, [0.5, 1.25, 0.75])
    assert [(name, list(parameters)) for name, parameters in design] == [("hinge", [0.5, 1.25]), ("link", [0.75])]
    assert design[-1][0] == "link"
    assert design.prefix(1).types == ["hinge"]


def test_an_index_beyond_the_design_is_an_index_error():
    with pytest.raises(IndexError, match="module 1 of a design of 1"):
        Design([("link", [0.5])])[1]


def test_equal_designs_are_equal_and_have_one_hash():
    a, b = Design([("link", [0.5])]), Design([("link", np.array([0.5]))])
    assert a == b and hash(a) == hash(b) and len({a, b}) == 1
    assert a != Design([("link", [0.6])])
    assert a != "link"


def test_repr_is_the_python_that_makes_the_design_again_bit_for_bit():
    design = Design([("hinge", [0.1 + 0.2, 1.0 / 3.0]), ("gripper", [])])
    assert eval(repr(design)) == design


def test_a_design_survives_pickle_and_copy():
    design = Design([("hinge", [0.1 + 0.2, 1.0 / 3.0])])
    assert pickle.loads(pickle.dumps(design)) == design
    assert copy.deepcopy(design) == design


def test_json_names_types_and_parameters_and_comes_back():
    design = Design([("hinge", [0.5, 1.25])])
    text = design.to_json("seed")
    assert '"type": "hinge"' in text and '"proximal": 0.5' in text and '"distal": 1.25' in text
    assert Design.from_json(text, modsearch.load_library("seed")) == design
    assert Design.from_json(text, modsearch.load_problem("seed/fixed")) == design


def test_json_that_is_no_design_is_a_file_error_that_names_the_place():
    with pytest.raises(modsearch.FileError, match="at /0/type.*hook"):
        Design.from_json('[{"type": "hook"}]', "seed")


@pytest.mark.parametrize(
    ("modules", "complaint"),
    [
        (3, "3 is no design"),
        ("hinge", "'hinge' is no design"),
        ([("hinge", [0.5, 1.0], 1)], "module 0 of the design"),
        ([("hinge", [[0.5, 1.0]])], "a vector is needed"),
        ([("hinge", [0.5] * 9)], "no type has more than 8"),
    ],
)
def test_what_is_no_design_is_a_value_error(modules, complaint):
    with pytest.raises(ValueError, match=complaint):
        Design(modules)
