"""The testbed in simulation, its firmware included: which effects does a diagnosis of its recorded logs name?"""
