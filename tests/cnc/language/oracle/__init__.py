"""What programs mean, told a second time and without the product's code: random texts with the outcome they must have.

`expressions`, `strings`: texts and values; `flow`, `flow_programs`: programs, run by a small
interpreter; `printing`: one block, written in many ways.
"""
