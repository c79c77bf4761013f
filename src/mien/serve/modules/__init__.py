"""The four modules (Frydrych et al. 2003): interpret, speak, translate, perform; and the streams that join them as
programs.
"""
